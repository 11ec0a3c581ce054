// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/session.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "device-io/emulator/fault_order.h"
#include "device-io/sixmotors/kinematics.h"
#include "proto/config/quantity.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/environment.h"
#include "proto/os/programs.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kLookNs = kMs;  // polling interval, fine enough for the reported times
constexpr int64_t kStartNs = 60 * kNsPerSecond;  // only a broken build takes this long to start
constexpr int64_t kJudgeNs = 10 * kMs;           // between two looks at the commands
constexpr int64_t kCommandContextNs = 20 * kMs;  // context before the first counted command
constexpr int64_t kStallsNs = 4 * kNsPerSecond;  // before a kill: the duration that a ring holds

/// A hand that always presses: 4.5 to 7 mm deep without resistance, which is 2.3 to 3.5 N.
const std::vector<std::string> kPressingHand{
    "--hand",  "stiff-arm",     "--centre", "0 mm",     "0 mm",
    "-7 mm",   "--direction",   "0",        "0",        "1",
    "--hover", "2.5 mm",        "--press",  "0 mm",     "--stroke-angle",
    "0 deg",   "--stroke-time", "3 s",      "--tremor", "0 mm"};
// With --bodies the hand presses and takes a block with mass. The block lies in a pocket, so that
// no fault moves it away from below the hand.
constexpr double kHalfBlockHeight = 0.02;  // of a block without mass [m]
constexpr double kBlock = 0.1;             // [kg]
constexpr double kHalfBlock = 0.02;        // edge [m]
constexpr double kPocket = 0.001;          // room to each side of it [m]
constexpr double kPocketDepth = 0.03;      // [m]
constexpr double kHalfWall = 0.02;         // [m]
constexpr double kHoldDamping = 3;         // a fifth of critical for it [N·s/m]
constexpr double kGravity = 9.81;          // [m/s²]
constexpr double kSway = 0.2;              // by which a resting hand may feel the block swing [N]
constexpr double kCalmSway = 0.05;         // of that, before a fault [N]
constexpr int64_t kTakenNs = 1500 * kMs;   // from then on, until the block hangs calm
constexpr size_t kCalm = 100;              // commands without a swing, whose period is 89 ms
const std::vector<std::string> kTakingHand{"--grasp", "-3 mm", "6 mm"};

/// With --six the hand also twists, by 1.5 degrees to either side.
const std::vector<std::string> kTwistingHand{
    "--six", "--turn-angle", "1.5 deg", "--turn-axis", "0", "1", "0"};

// The tool of six degrees of freedom is a cube whose bottom is tilted in the grip, so that it is
// turned at any time, by 11 to 24 mN·m. Deeper than 1.1 mm it lies flat.
constexpr double kHalfCube = 0.045;          // [m]
constexpr double kTiltOfTool = 0.07;         // about y [rad]
constexpr double kTurningStiffness = 0.25;   // [N·m/rad]
constexpr double kMaxTorque = 0.03;          // [N·m]
constexpr double kMaxTurningDamping = 2e-3;  // [N·m·s/rad]
constexpr double kTorqueSlew = 1.7;          // to the largest in 18 ms, as the force [N·m/s]

constexpr const char* kSession = R"(
[session]
name = "{name}"
realtime = {realtime}
)";
constexpr const char* kGraspMap = R"(
[map]
grasp_button = 0
)";
constexpr const char* kSixTool = R"(
[tool]
primitive = "box"
extent = ["{cube} m", "{cube} m", "{cube} m"]
[contact.rigid]
margin = "1 um"
[map.tool_on_grip]
rotation = {axis = [0, 1, 0], angle = "{tilt} rad"}
)";
constexpr const char* kSixDevice = R"(
[device]
kind = "six-motors"
max_torque = "0.3 N·m"
max_rotational_damping = "{turning_damping} N·m·s/rad"
)";
constexpr const char* kRules = R"(
max_force = "5 N"
max_damping = "{damping} N·s/m"
[device.serial]
path = "{folder}/device"
[coupling]
stiffness = "{stiffness} N/m"
{rotational_stiffness}
[safety]
armed_at_start = true
max_force = "{force} N"
soft_start = "{soft_start} s"
slew = "{slew} N/s"
)";
constexpr const char* kSixRules = R"(max_torque = "{torque} N·m"
torque_slew = "{torque_slew} N·m/s"
)";
constexpr const char* kMovable = R"(
[object.material]
friction_static = 0.0
friction_dynamic = 0.0
[object.body]
mass = "{mass} kg"
)";
constexpr const char* kSim = R"(
[sim]
gravity = ["0 m/s²", "0 m/s²", "-{gravity} m/s²"]
)";

/// A block with mass on the ground, whose top is where the handle is, between four walls. It is
/// what a hand presses as it would a fixed one, and takes.
std::string block_in_pocket() {
  constexpr double kBottom = -2 * kHalfBlock, kMiddle = kHalfBlock + kPocket + kHalfWall;
  constexpr double kWall = kBottom + kPocketDepth / 2;
  constexpr Vec3 kAlongY{2 * kHalfWall, 4 * kMiddle, kPocketDepth};
  constexpr Vec3 kAlongX{2 * (kHalfBlock + kPocket), 2 * kHalfWall, kPocketDepth};
  return box("block", {2 * kHalfBlock, 2 * kHalfBlock, 2 * kHalfBlock}, {0, 0, -kHalfBlock}) +
         filled(kMovable, {{"mass", number_text(kBlock)}}) +
         box("ground", {0.2, 0.2, 0.04}, {0, 0, kBottom - 0.02}) +
         box("wall to the one side of x", kAlongY, {-kMiddle, 0, kWall}) +
         box("wall to the one side of y", kAlongX, {0, -kMiddle, kWall}) +
         box("wall to the other side of x", kAlongY, {kMiddle, 0, kWall}) +
         box("wall to the other side of y", kAlongX, {0, kMiddle, kWall}) +
         filled(kSim, {{"gravity", number_text(kGravity)}});
}

/// The end of a file, for an error message; the file is deleted with its folder.
std::string last_lines(const std::string& path) {
  constexpr size_t kMost = 1000;
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  const std::string all = text.str();
  return all.size() > kMost ? "…" + all.substr(all.size() - kMost) : all;
}

template <typename Source, typename Time>
void note_writer(WriterSeen& seen, const Source& source, Time time_of) {
  if (source.item_generation() == seen.generation) return;
  seen = {static_cast<pid_t>(source.header()->pid.load()), source.item_generation(), time_of()};
}

}  // namespace

std::string find_on_path(const std::string& program) {
  std::istringstream folders(environment("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string path = std::move(folder);
    path += "/" + program;
    if (access(path.c_str(), X_OK) == 0) return path;
  }
  return "";
}

TortureSession::Variable::Variable(const char* name, const std::string& value) : name_(name) {
  if (const char* before = std::getenv(name)) before_ = before;
  setenv(name, value.c_str(), 1);
}

TortureSession::Variable::~Variable() {
  before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_);
}

TortureSession::Watch::Watch(FileDescriptor socket)
    : attachments(std::move(socket)),
      servo(attachments.ring<&ServoChannels::frames>(Start::kOldest)),
      contact(attachments.ring<&ContactChannels::sets>(Start::kOldest)),
      sim(attachments.ring<&SimChannels::frames>(Start::kOldest)) {
  attachments.start();
}

void TortureSession::Watch::drain(std::vector<SeenFrame>& published) {
  for (ServoFrame frame; servo.next(frame);) {
    note_writer(servo_seen, servo, [&] { return frame.t_ns; });
    if ((frame.flags & kServoFault) != 0) servo_seen.fault_ns = frame.t_ns;
    published.push_back({frame.t_ns, now_ns()});
  }
  for (ContactSet set{}; contact.next(set);) {
    note_writer(contact_seen, contact, [&] { return set.answers_t_ns; });
  }
  for (SceneFrame frame; sim.next(frame);) {
    note_writer(sim_seen, sim, [&] { return frame.t_ns; });
    scene = frame;
  }
}

TortureSession::TortureSession(const TortureOptions& options)
    : options_(options),
      programs_(program_folder()),
      runtime_dir_("HAPTICD_RUNTIME_DIR", options.folder + "/run"),
      libexec_("HAPTICD_LIBEXEC", options.folder + "/programs"),
      witness_(options.realtime),
      normal_witness_(false),
      reader_(options.folder + "/received.csv") {
  fs::create_directories(options_.folder);
  link_programs(programs_);
  start_emulator();
  start_hapticd();
  if (options_.given) start_holder();
  start_recorder();
  const bool is_given =
      !options_.given || wait_until([this] { return is_let_in(0, kGivers); }, kStartNs);
  if (!is_given || !wait_whole(now_ns(), kStartNs)) {
    throw std::runtime_error(
        "the session does not get as far as a force; its programs said last: " +
        last_lines(options_.folder + "/said"));
  }
}

TortureSession::~TortureSession() {
  stop();
}

/// A folder of programs in which the faulty contact replaces the real one.
void TortureSession::link_programs(const std::string& from) const {
  const std::string to = options_.folder + "/programs";
  fs::create_directories(to);
  const auto link = [&](const std::string& name, const std::string& target) {
    if (access(target.c_str(), X_OK) != 0) throw std::runtime_error(cannot_start(target, errno));
    fs::create_symlink(target, to + "/" + name);
  };
  for (const char* name : {"hapticd", "hapt", "haptic-servo", "haptic-sim", "haptic-emulator"}) {
    link(name, from + "/" + name);
  }
  link("haptic-contact", from + "/haptic-faulty-contact");
  link("haptic-faulty-giver", from + "/haptic-faulty-giver");
  if (const std::string stress = find_on_path("stress-ng"); !stress.empty()) {
    link("stress-ng", stress);
  }
}

std::vector<ForceRules> TortureSession::rules() const {
  ForceRules force;
  // the block lies up to so deep in the ground: sim lets contacts of 10 µm be [m]
  constexpr double kRests = 20e-6;
  if (options_.bodies) force.step += force.stiffness * kRests;
  if (holds_) {
    force.weight = kBlock * kGravity;
    force.sway = kSway;
    force.pressing = 0;
    force.in_a_row = kCalm;
  }
  if (!options_.six) return {force};
  force.arm = &six_motors_arm();
  constexpr double kMostTilt = 0.1;  // [rad]
  force.bend = force.stiffness * kHalfCube * kMostTilt * kMostTilt / 2;
  force.step +=
      6e-3 - ForceRules{}.step;  // what the wrist's motors make of their half milliampere as well
  return {force,
          {.stiffness = kTurningStiffness,
           .max_force = kMaxTorque,
           .max_damping = kMaxTurningDamping,
           .slew = kTorqueSlew,
           .part = Part::kTorque,
           .step = 2e-4,
           .bend = kTurningStiffness * kMostTilt * kMostTilt / 2,
           .pressing = 0.02,
           .arm = force.arm,
           .tool_on_grip = from_rotation_vector({0, kTiltOfTool, 0})}};
}

/// The block's top is where the tool's middle, which is the handle, has half a cube below it.
std::string TortureSession::write_config() const {
  const ForceRules r = rules().front();
  const bool six = options_.six;
  const std::string text =
      std::string(kSession) + (six ? "renderer = \"god-object6\"\n" : "") +
      (options_.bodies ? kGraspMap : "") +
      (six ? std::string(kSixTool) + kSixDevice : "\n[device]\nkind = \"woodenhaptics\"") + kRules +
      (six ? kSixRules : "");
  const std::string objects = options_.bodies
                                  ? block_in_pocket()
                                  : box("block", {0.2, 0.2, 2 * kHalfBlockHeight},
                                        {0, 0, (six ? -kHalfCube : 0) - kHalfBlockHeight});
  const std::string turning =
      "rotational_stiffness = \"" + number_text(kTurningStiffness) + " N·m/rad\"";
  std::string path = options_.folder + "/torture.toml";
  std::ofstream(path) << filled(text, {{"name", name_},
                                       {"realtime", options_.realtime ? "true" : "false"},
                                       {"cube", number_text(2 * kHalfCube)},
                                       {"tilt", number_text(kTiltOfTool)},
                                       {"turning_damping", number_text(kMaxTurningDamping)},
                                       {"damping", number_text(r.max_damping)},
                                       {"folder", options_.folder},
                                       {"stiffness", number_text(r.stiffness)},
                                       {"rotational_stiffness", six ? turning : ""},
                                       {"force", number_text(r.max_force)},
                                       {"soft_start", number_text(r.soft_start)},
                                       {"slew", number_text(r.slew)},
                                       {"torque", number_text(kMaxTorque)},
                                       {"torque_slew", number_text(kTorqueSlew)}})
                      << objects << text_of_givers() << (options_.given ? text_of_holder() : "");
  return path;
}

void TortureSession::start_emulator() {
  std::vector<std::string> words = kPressingHand;
  if (options_.bodies) words.insert(words.end(), kTakingHand.begin(), kTakingHand.end());
  if (options_.six) words.insert(words.end(), kTwistingHand.begin(), kTwistingHand.end());
  words.insert(words.end(),
               {"--link", options_.folder + "/device", "--log", options_.folder + "/received.csv"});
  if (options_.realtime) words.push_back("--realtime");
  emulator_ = std::make_unique<SessionProcess>("haptic-emulator", words, options_.folder + "/said");
  const int64_t give_up_ns = now_ns() + kStartNs;
  while (!fs::is_symlink(options_.folder + "/device")) {
    if (emulator_->exit_code() || now_ns() > give_up_ns) {
      throw std::runtime_error("haptic-emulator did not start; what it said is in " +
                               options_.folder + "/said");
    }
    sleep_until(now_ns() + kLookNs);
  }
}

void TortureSession::start_hapticd() {
  hapticd_ = std::make_unique<SessionProcess>("hapticd", std::vector<std::string>{write_config()},
                                              options_.folder + "/said");
  if (watch_) unseen_ += watch_->lost();
  watch_.reset();
  for (const int64_t give_up_ns = now_ns() + kStartNs; !watch_; sleep_until(now_ns() + kLookNs)) {
    if (hapticd_->exit_code() || now_ns() > give_up_ns) {
      throw std::runtime_error("hapticd did not start; what it said is in " + options_.folder +
                               "/said");
    }
    try {
      FileDescriptor socket = connect_session(name_);
      if (peer_of(socket).hapticd == hapticd_->pid()) {
        watch_ = std::make_unique<Watch>(std::move(socket));
      }
    } catch (const HandoutError&) {
      // not yet
    }
  }
}

void TortureSession::start_recorder() {
  if (options_.recording.empty()) return;
  const std::string number = parts_.empty() ? "" : "-" + std::to_string(parts_.size() + 1);
  parts_.push_back({options_.recording + number + ".mcap"});
  recorder_ =
      std::make_unique<SessionProcess>("hapt",
                                       std::vector<std::string>{"record", "-o", parts_.back().path,
                                                                "--overwrite", "--session", name_},
                                       options_.folder + "/said");
  recorder_waits_.emplace(recorder_->pid());
}

std::unique_ptr<SessionProcess> TortureSession::run_giver(uint32_t client) const {
  const Vec3 place = place_of_given(client);
  return std::make_unique<SessionProcess>(
      "haptic-faulty-giver",
      std::vector<std::string>{name_, name_of_given(client), number_text(place.x),
                               number_text(place.y), number_text(place.z)},
      options_.folder + "/said");
}

void TortureSession::start_holder() {
  holder_ = std::make_unique<SessionProcess>(
      "haptic-faulty-giver",
      std::vector<std::string>{name_, "block", "0", "0", number_text(-kHalfBlockHeight), "still"},
      options_.folder + "/said");
}

const SceneObject* TortureSession::given_object(uint32_t client) const {
  const SceneFrame* newest = scene();
  if (newest == nullptr || newest->objects.size() < kGivers) return nullptr;
  return &newest->objects[newest->objects.size() - kGivers + client];
}

/// An object is where its client has it, and is felt.
bool TortureSession::is_let_in(size_t object, uint32_t client) const {
  if (!watch_->scene || object >= watch_->scene->objects.size()) return false;
  const SceneObject& seen = watch_->scene->objects[object];
  return seen.mover == moved_by_client(client) && seen.reduction == 0;
}

bool TortureSession::start_giver(int64_t patience_ns) {
  // one whose hapticd was killed has ended
  if (bystander_ == nullptr || bystander_->exit_code()) bystander_ = run_giver(kBystander);
  giver_number_ = (giver_number_ + 1) % kBystander;
  giver_ = run_giver(giver_number_);
  const auto are_let_in = [this] {
    const size_t first = scene() != nullptr ? scene()->objects.size() - kGivers : 0;
    return is_let_in(first + giver_number_, giver_number_) &&
           is_let_in(first + kBystander, kBystander);
  };
  return wait_until(are_let_in, patience_ns);
}

/// Frames seen up to now must be in the recorder's file, later ones need not.
void TortureSession::end_part() {
  if (!recorder_ || parts_.back().n_seen != RecordingPart::kRuns) return;
  watch_->drain(published_);
  parts_.back().n_seen = published_.size();
}

void TortureSession::kill_recorder() {
  if (!recorder_) return;
  end_part();
  RecordingPart& part = parts_.back();
  part.killed_ns = now_ns();
  recorder_waits_->look(part.killed_ns);
  recorder_->kill();
  const int64_t since_ns = part.killed_ns - kStallsNs;
  part.stalls = merge_stalls(stalls_of_starts(since_ns), recorder_waits_->stalls(since_ns));
}

int64_t TortureSession::kill_hapticd() {
  // marked first: the recorder ends with its session, but the servo publishes a little longer
  end_part();
  hapticd_->send(SIGKILL);
  const int64_t killed_ns = now_ns();
  hapticd_->kill();
  return killed_ns;
}

void TortureSession::restart_hapticd() {
  start_hapticd();
  // the previous recorder has ended with its session
  if (recorder_) recorder_->stop();
  start_recorder();
}

void TortureSession::stop() {
  end_part();
  for (auto* process : {&recorder_, &giver_, &bystander_, &holder_, &hapticd_, &emulator_}) {
    if (!*process) continue;
    (*process)->send(SIGCONT);
    (*process)->stop();
    if (watch_) watch_->drain(published_);
  }
}

void TortureSession::update() {
  watch_->drain(published_);
  reader_.read(records_);
  if (recorder_waits_) recorder_waits_->look(now_ns());
  if (emulator_->exit_code()) {
    throw std::runtime_error("haptic-emulator has ended; what it said is in " + options_.folder +
                             "/said");
  }
}

void TortureSession::pause(int64_t duration_ns) {
  wait_until([] { return false; }, duration_ns);
}

bool TortureSession::wait_until(const std::function<bool()>& condition, int64_t patience_ns) {
  const int64_t give_up_ns = now_ns() + patience_ns;
  for (update(); !condition(); update()) {
    if (now_ns() >= give_up_ns) return false;
    sleep_until(now_ns() + kLookNs);
  }
  return true;
}

std::optional<int64_t> TortureSession::wait_whole(int64_t from_ns, int64_t patience_ns) {
  return wait_whole(rules(), from_ns, patience_ns);
}

bool TortureSession::wait_calm(int64_t patience_ns) {
  std::vector<ForceRules> parts = rules();
  for (ForceRules& part : parts) part.sway = std::min(part.sway, kCalmSway);
  return wait_whole(parts, now_ns(), patience_ns).has_value();
}

std::optional<int64_t> TortureSession::wait_whole(std::vector<ForceRules> parts, int64_t from_ns,
                                                  int64_t patience_ns) {
  std::optional<int64_t> whole_ns;
  int64_t look_ns = 0;
  wait_until(
      [&] {
        if (now_ns() < look_ns) return false;
        look_ns = now_ns() + kJudgeNs;
        whole_ns = from_ns;
        for (const ForceRules& part : parts) {
          const auto whole = whole_again(part, records_since(from_ns - kCommandContextNs), from_ns);
          whole_ns = whole && whole_ns ? std::max(whole_ns, whole) : std::nullopt;
        }
        return whole_ns.has_value();
      },
      patience_ns);
  return whole_ns;
}

bool TortureSession::take(int64_t patience_ns) {
  holds_ = true;
  ask("set damping " + std::to_string(kHoldDamping) + " N·s/m");
  // a hand that swings may not touch the block when it presses the button
  for (const int64_t give_up_ns = now_ns() + patience_ns; now_ns() < give_up_ns;) {
    send_order(emulator_->pid(), static_cast<int>(EmulatorFault::kGrasp));
    pause(kReachNs);
    if (wait_calm(kTakenNs)) return true;
  }
  return false;
}

bool TortureSession::let_go(int64_t patience_ns) {
  holds_ = false;
  ask("set damping 0 N·s/m");
  send_order(emulator_->pid(), static_cast<int>(EmulatorFault::kLetGo));
  pause(kReachNs);
  return wait_whole(now_ns(), patience_ns).has_value();
}

std::span<const EmulatorRecord> TortureSession::records_since(int64_t t_ns) const {
  const auto first = std::find_if(records_.begin(), records_.end(),
                                  [&](const EmulatorRecord& r) { return r.t_ns >= t_ns; });
  return {first, records_.end()};
}

void TortureSession::forget_before(int64_t t_ns) {
  std::erase_if(records_, [&](const EmulatorRecord& r) { return r.t_ns < t_ns; });
}

std::vector<Stall> TortureSession::stalls(int64_t since_ns, bool emulator_too) const {
  std::vector<Stall> of_emulator;
  if (emulator_too) of_emulator = emulator_stalls(records_since(since_ns));
  return merge_stalls(witness_.stalls(since_ns), of_emulator);
}

std::string TortureSession::ask(const std::string& line) const {
  try {
    return say_to_session(name_, line);
  } catch (const HandoutError& error) {
    return std::string("error: ") + error.what();
  }
}

}  // namespace haptic
