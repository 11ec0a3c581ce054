// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-emulator: a simulated WoodenHaptics, Polhem or device with six motors, behind a
// pseudo-terminal, in its own process with its own clock. A server sees only its bytes. It logs the
// wrench that it received.
#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "device-io/emulator/fault_order.h"
#include "device-io/emulator/firmware.h"
#include "device-io/emulator/line_workers.h"
#include "device-io/emulator/log.h"
#include "device-io/hand/impedance.h"
#include "device-io/hand/intent.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "proto/config/command_line.h"
#include "proto/config/quantity.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/queued_order.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kTurnNs = 250'000;  // of the firmware's loop: two microframes of USB
constexpr int kLinePriority = 65;     // below both ends of the line

/// A device that can be emulated, by its option. Moving mass, damping and friction at the handle
/// are estimates, not measured.
struct Kind {
  const Arm& arm;
  double mass, damping, inertia;  // [kg], [N·s/m], [kg·m²]; 0: the handle does not turn
};
constexpr double kFriction = 0.2;  // at the tip of each [N]

Kind kind_of(bool six, bool polhem) {
  if (six && polhem) throw UsageError("--six, --polhem: are two devices; give one");
  // an arm that carries a wrist
  if (six) return {six_motors_arm(), 0.25, 0.5, 1e-4};
  // by the published masses of its links: 80 to 160 g each
  if (polhem) return {polhem_arm(), 0.3, 0.3, 1e-4};
  return {woodenhaptics_arm(), 0.15, 0.3, 0};
}

struct Options {
  std::string link, log, hand = "typical";
  double button = 0;                    // [s]
  std::vector<double> centre{0, 0, 0};  // [m]
  std::vector<double> direction, turn_axis;
  IntentConfig intent;
  uint64_t seed = 1;
  bool realtime = false;
  bool six = false, polhem = false;
  std::vector<double> grasp;  // heights at which the hand takes a thing, and holds it [m]
};

std::vector<std::string> hand_names() {
  std::vector<std::string> names;
  for (const HandImpedance& hand : kHandImpedances) names.emplace_back(hand.name);
  return names;
}

/// A direction of the command line; zero: not given.
Vec3 direction_of(const std::vector<double>& words) {
  return words.empty() ? Vec3{} : normalized(Vec3{words[0], words[1], words[2]});
}

EmulatedDeviceOptions device_options(const Options& options) {
  const Kind kind = kind_of(options.six, options.polhem);
  if (!options.grasp.empty() && (options.six || options.polhem)) {
    throw UsageError("--grasp: this device has no button; leave --six and --polhem out");
  }
  EmulatedDeviceOptions device;
  device.arm = &kind.arm;
  device.hand.mass = kind.mass;
  device.hand.damping = kind.damping;
  device.hand.inertia = kind.inertia;
  device.hand.coulomb_friction = kFriction;
  device.hand.seed = options.seed;
  put_into_hand(*find_hand(options.hand), device.hand);
  IntentConfig& intent = device.hand.intent = options.intent;
  intent.centre_B = {options.centre[0], options.centre[1], options.centre[2]};
  intent.direction_B = direction_of(options.direction);
  intent.turn_axis_B = direction_of(options.turn_axis);
  device.button_ns = static_cast<int64_t>(1e9 * options.button);
  return device;
}

/// Throws if the hand is to go where the arm cannot reach.
void check_reach(const EmulatedDeviceOptions& device, const std::vector<double>& grasp) {
  const IntentConfig& intent = device.hand.intent;
  JointAngles reached;
  for (const double height : grasp) {
    if (device.arm->solve({{0, 0, height}, {}}, reached)) continue;
    throw UsageError("--grasp: the arm does not reach so far; give heights nearer to 0 mm");
  }
  if (!(intent.stroke_time > 0)) {
    throw UsageError("--stroke-time: is zero; write for example \"1.2 s\"");
  }
  if (intent.turn_angle != 0 && !can_turn(device.hand)) {
    throw UsageError("--turn-angle: this device does not turn; give --six as well, or --polhem");
  }
  JointAngles angles;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.02 * i * intent.stroke_time;
    const Intent at = intent_at(intent, device.hand.seed, t);
    if (!device.arm->solve({at.p_B, {}}, angles)) {
      throw UsageError(
          "the hand would go where the arm does not reach; move --centre to the origin, or make "
          "--hover smaller");
    }
    if (device.arm->solve({at.p_B, at.q_B}, angles)) continue;
    throw UsageError(
        "the hand would turn where the wrist does not reach; make --turn-angle smaller");
  }
}

struct Pty {
  FileDescriptor master, slave;
  std::string name;
};

/// Keeps the slave end open: a device keeps its power when a server closes the node.
Pty open_pty() {
  int master = -1, slave = -1;
  termios raw{};
  cfmakeraw(&raw);
  if (openpty(&master, &slave, nullptr, &raw, nullptr) != 0) {
    throw std::runtime_error(std::string("no pseudo-terminal: ") + std::strerror(errno) +
                             "; mount /dev/pts");
  }
  Pty pty{FileDescriptor(master), FileDescriptor(slave), {}};
  std::array<char, 64> name{};
  ttyname_r(slave, name.data(), name.size());
  pty.name = name.data();
  fcntl(master, F_SETFL, fcntl(master, F_GETFL) | O_NONBLOCK);
  for (const int fd : {master, slave}) fcntl(fd, F_SETFD, FD_CLOEXEC);
  return pty;
}

/// A symbolic link with a fixed name for configs; removed at the end.
class Link {
 public:
  Link(const std::string& path, const std::string& target) : path_(path) {
    if (path_.empty()) return;
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::is_symlink(path_, error)) fs::remove(path_, error);
    fs::create_symlink(target, path_, error);
    if (error) {
      throw std::runtime_error(path_ + ": cannot be made a link: " + error.message() +
                               "; give --link another name");
    }
  }
  ~Link() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  }
  Link(const Link&) = delete;

 private:
  std::string path_;
};

/// A hand that, when a test orders it, reaches down to the object below it, presses its button and
/// lifts the object, or releases the button and goes back to its strokes.
class GraspingHand {
 public:
  explicit GraspingHand(const std::vector<double>& heights) : heights_(heights) {}

  void take(EmulatedDevice& device, int64_t t_ns) {
    if (heights_.empty()) return;
    device.press(0);
    device.lead(Vec3{0, 0, heights_[0]});
    there_ns_ = t_ns + kReachNs;
  }
  void let_go(EmulatedDevice& device) {
    device.press(0);
    device.lead({});
    there_ns_.reset();
  }
  void follow(EmulatedDevice& device, int64_t t_ns) {
    if (!there_ns_ || t_ns < *there_ns_) return;
    device.press(1);
    device.lead(Vec3{0, 0, heights_[1]});
    there_ns_.reset();
  }

 private:
  std::vector<double> heights_;
  std::optional<int64_t> there_ns_;  // when it will have reached the thing
};

/// Carries out orders of a test.
void obey_orders(EmulatedDevice& device, GraspingHand& hand) {
  const auto order = static_cast<EmulatorFault>(take_order());
  switch (order) {
    case EmulatorFault::kJumpOnce:
      return device.disturb(kJumpCounts, 1);
    case EmulatorFault::kJump:
      return device.disturb(kJumpCounts, std::numeric_limits<uint64_t>::max());
    case EmulatorFault::kTurnJumpOnce:
      return device.disturb(kTurnJumpCounts, 1);
    case EmulatorFault::kTurnJump:
      return device.disturb(kTurnJumpCounts, std::numeric_limits<uint64_t>::max());
    case EmulatorFault::kHealthy:
      device.disturb({}, 0);
      return device.lie(EmulatorFault::kHealthy);
    case EmulatorFault::kFrozen:
    case EmulatorFault::kOldFirst:
    case EmulatorFault::kDelayed:
    case EmulatorFault::kNoise:
    case EmulatorFault::kTurnNoise:
      return device.lie(order);
    case EmulatorFault::kGrasp:
      return hand.take(device, now_ns());
    case EmulatorFault::kLetGo:
      return hand.let_go(device);
    default:
      return;
  }
}

void serve(EmulatedDevice& device, GraspingHand hand, const Pty& pty, EmulatorLog& log) {
  std::array<char, 1024> bytes;
  DeadlineClock clock(kTurnNs);
  while (!stop_requested()) {
    clock.wait();
    obey_orders(device, hand);
    hand.follow(device, now_ns());
    const ssize_t n = read(pty.master.get(), bytes.data(), bytes.size());
    if (n > 0) device.receive({bytes.data(), static_cast<size_t>(n)});
    if (device.turn(now_ns())) log.add(device.record());
    const std::string_view answer = device.answer();
    // like a real device, loses answers that a server does not read
    if (!answer.empty() && write(pty.master.get(), answer.data(), answer.size()) < 0) continue;
  }
}

int run(const Options& options) {
  const EmulatedDeviceOptions device_parameters = device_options(options);
  check_reach(device_parameters, options.grasp);
  const Pty pty = open_pty();
  EmulatorLog log(options.log);
  const Link link(options.link, pty.name);
  catch_stop_signals();
  catch_orders();
  std::printf("haptic-emulator: SIMULATED %s at %s, hand: %s\n",
              std::string(device_parameters.arm->name).c_str(), pty.name.c_str(),
              options.hand.c_str());
  std::fflush(stdout);
  // started first: a thread of normal priority
  std::optional<LineWorkers> line_workers;
  if (options.realtime) line_workers.emplace(kLinePriority);
  if (options.realtime) enter_realtime({.fifo_priority = kEmulatorPriority, .lock_memory = true});
  EmulatedDevice device(device_parameters, now_ns());
  serve(device, GraspingHand(options.grasp), pty, log);
  const EmulatorLog::Outcome outcome = log.finish();
  const EmulatorRecord& last = device.record();
  std::printf("haptic-emulator: %llu commands, %llu dropped, watchdog %llu times, %llu records\n",
              static_cast<unsigned long long>(last.commands),
              static_cast<unsigned long long>(last.rejected),
              static_cast<unsigned long long>(last.watchdog),
              static_cast<unsigned long long>(outcome.rows));
  if (outcome.lost == 0 && outcome.written) return kExitClean;
  std::fprintf(stderr, "haptic-emulator: %s: %llu records lost; use a faster or emptier disk\n",
               shown(options.log).c_str(), static_cast<unsigned long long>(outcome.lost));
  return kExitCrash;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) try {
  haptic::Options options;
  haptic::IntentConfig& intent = options.intent;
  intent.hover_radius = 0.05;  // within the reach of all three
  haptic::CommandLine line(
      "haptic-emulator",
      "A simulated WoodenHaptics in a simulated hand, behind a serial node; "
      "with --six one with six motors, with --polhem a Polhem, whose handles turn.");
  line.option("--link PATH", options.link, "name of the node, for [device.serial] path");
  line.option("--log FILE.csv", options.log, "what the device received and where it was");
  line.flag("--six", options.six, "six motors: a session with kind = \"six-motors\"");
  line.flag("--polhem", options.polhem, "a Polhem: a session with kind = \"polhem\"");
  line.option("--hand HAND", options.hand, "impedance: none, light-grip, typical, firm, stiff-arm")
      .one_of(haptic::hand_names())
      .show_default();
  line.option("--seed", options.seed, "of the strokes: the same seed, the same strokes")
      .show_default();
  using haptic::Dimension;
  constexpr haptic::Range kDelays{0, 3600};  // longer than anybody waits
  constexpr haptic::Range kHalfTurn{0, std::numbers::pi, true};
  const auto length = [&](const char* name, double& value, const char* help) {
    line.quantity(name, value, Dimension::kLength, haptic::kNotNegative, help).show_default();
  };
  line.quantity("--centre X Y Z", options.centre, Dimension::kLength, haptic::kAny,
                "of the strokes")
      .expected(3);
  line.number("--direction X Y Z", options.direction, haptic::kAny, "all strokes along it")
      .expected(3);
  length("--hover", intent.hover_radius, "distance from the centre between strokes");
  length("--press", intent.press_radius, "distance from the centre the hand means to reach");
  line.quantity("--stroke-angle", intent.stroke_angle, Dimension::kAngle, haptic::kAny,
                "arc of a stroke; 0 deg: press on one spot");
  line.quantity("--stroke-time", intent.stroke_time, Dimension::kTime, haptic::kNotNegative,
                "reach (1/4), slide or press (1/2), lift (1/4)");
  line.quantity("--turn-angle", intent.turn_angle, Dimension::kAngle, kHalfTurn,
                "turn of the handle in each stroke")
      .show_default();
  line.number("--turn-axis X Y Z", options.turn_axis, haptic::kAny, "all turns about it")
      .expected(3);
  length("--tremor", intent.tremor_amplitude, "amplitude");
  line.quantity("--button-after", options.button, Dimension::kTime, kDelays,
                "calibration button; 0 s: is not needed");
  line.quantity("--grasp LOW HIGH", options.grasp, Dimension::kLength, haptic::kAny,
                "heights at which the hand takes and holds a thing, when a test orders it")
      .expected(2);
  line.flag("--realtime", options.realtime, "real-time priority, where the kernel grants it");
  line.example("haptic-emulator --link /tmp/woodenhaptics --log received.csv");
  line.example("haptic-emulator --six --link /tmp/six --turn-angle \"20 deg\"");
  if (const auto code = line.read(argc, argv)) return *code;
  return haptic::run(options);
} catch (const std::exception& error) {
  return haptic::report_failure("haptic-emulator", error);
}
