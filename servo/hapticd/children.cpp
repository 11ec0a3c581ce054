// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/children.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <ranges>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "proto/config/devices.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sealed_file.h"
#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

constexpr int64_t kTellWaitingNs = 10'000 * kMs;  // between log lines before the first contact
constexpr int64_t kServoStopNs = 1000 * kMs;      // for the servo alone, part of kStopNs
constexpr int64_t kStopNs = 2000 * kMs;           // then children are killed
constexpr int64_t kRetryStartNs = 500 * kMs;      // if the kernel has no resources for a process
constexpr int64_t kSpareAfterNs = 500 * kMs;  // after contact's start, when its meshes are baked

template <typename Channels>
Role role_of(const char* program, double rate, Attachments& attachments, uint32_t hand) {
  const SegmentSpec spec = segment_spec<Channels>(hand);
  return {.program = program,
          .name = spec.name,
          .id = spec.id,
          .hand = hand,
          .period_ns = period_ns(rate),
          .delay_ns = restart_delay_ns,
          .events = attachments.ring<&Channels::events>(Start::kOldest, hand)};
}

/// Sim, for each hand contact and servo, and last the spare.
std::vector<Role> roles_of(const SessionRun& session, Attachments& attachments) {
  const double rate = session.config.sim_rate;
  std::vector<Role> roles;
  roles.push_back(role_of<SimChannels>("haptic-sim", rate, attachments, kFirstHand));
  for (const SessionConfig& config : session.hands) {
    roles.push_back(role_of<ContactChannels>("haptic-contact", config.contact_poll_rate,
                                             attachments, config.hand));
    roles.push_back(
        role_of<ServoChannels>("haptic-servo", config.servo_rate, attachments, config.hand));
  }
  roles.push_back({.program = "haptic-contact",
                   .name = session.hands.size() == 1 ? "contact0 spare" : "contact spare",
                   .id = contact_segment(kFirstHand),
                   .hand = kFirstHand,
                   .period_ns = period_ns(session.config.contact_poll_rate),
                   .delay_ns = spare_delay_ns});
  return roles;
}

/// Gives hapticd its end of a spare's socket, and returns the spare's. Throws std::system_error.
FileDescriptor connect_spare(FileDescriptor& turn) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot make a socket pair");
  }
  turn = FileDescriptor(ends[0]);
  return FileDescriptor(ends[1]);
}

}  // namespace

Children::Children(SessionRun& session, Attachments& attachments)
    : session_(session),
      folder_(program_folder()),
      config_file_(make_sealed_file("haptic-config", std::as_bytes(std::span(session.hands)))),
      roles_(roles_of(session, attachments)) {
  for (const SessionConfig& config : session.hands) {
    const bool has_node = row_of(config.device.kind).has_node();
    devices_.push_back(has_node ? std::make_unique<Guarded>(config, attachments) : nullptr);
  }
  for (const Role& role : roles_) {
    const std::string path = folder_ + "/" + role.program;
    if (access(path.c_str(), X_OK) != 0) throw std::runtime_error(cannot_start(path, errno));
  }
}

Children::~Children() {
  stop();
}

void Children::guard_devices() {
  for (const auto& device : devices_) {
    if (device) device->guard.start();
  }
}

void Children::start() {
  for (Role& role : roles_) {
    if (!is_servo(role) && &role != &spare()) start(role);
  }
  told_waiting_ns_ = now_ns();
}

void Children::take_offer(const Announcement& offer) {
  for (Role& role : roles_) {
    const bool is_its = role.id == offer.id && role.generation == offer.generation;
    if (!is_its) continue;
    if (role.life.phase != Phase::kWaiting) role.life.phase = Phase::kRunning;
    if (!is_contact_of_hand(role)) continue;
    Role& servo = servo_of(role.hand);
    if (servo.generation == 0) servo.start_at_ns = 0;
    if (session_.config.contact_spare != 0) spare().start_at_ns = now_ns() + kSpareAfterNs;
  }
}

int64_t Children::wait_for(std::span<pollfd, kWaits> waiting) const {
  int64_t next_ns = Role::kNever;
  // poll ignores the −1 of a process that does not run
  std::ranges::fill(waiting, pollfd{-1, POLLIN, 0});
  for (size_t i = 0; i < roles_.size(); ++i) {
    const ChildProcess& child = roles_[i].child;
    waiting[2 * i].fd = child.pidfd.get();
    waiting[2 * i + 1].fd = child.output.get();
    next_ns = std::min(next_ns, start_time(roles_[i]));
  }
  return next_ns;
}

void Children::write_output() {
  for (Role& role : roles_) role.child.write_output(session_.log, role.name);
}

uint64_t Children::next_generation(const Role& role) {
  if (&role != &spare()) return ++newest_generation_[role.id];
  uint64_t newest = 0;
  for (const SessionConfig& config : session_.hands) {
    newest = std::max(newest, newest_generation_[contact_segment(config.hand)]);
  }
  for (const SessionConfig& config : session_.hands) {
    newest_generation_[contact_segment(config.hand)] = newest + 1;
  }
  return newest + 1;
}

void Children::launch(Role& role) {
  role.generation = next_generation(role);
  const FileDescriptor socket = session_.server.connect_child(role.id, role.generation);
  const FileDescriptor turn = &role == &spare() ? connect_spare(turn_) : FileDescriptor();
  Guarded* const device = device_of(role);
  const std::pair<const char*, int> handed[] = {
      {"--config-fd", config_file_.get()},
      {"--control-fd", socket.get()},
      {"--device-fd", device != nullptr ? device->guard.node_for_servo() : -1},
      {"--spare-fd", turn.get()}};
  std::vector<std::string> words;
  std::vector<int> kept;
  for (const auto& [key, fd] : handed) {
    if (fd < 0) continue;
    words.insert(words.end(), {key, std::to_string(fd)});
    kept.push_back(fd);
  }
  words.insert(words.end(), {"--generation", std::to_string(role.generation), "--hand",
                             std::to_string(role.hand)});
  role.child.launch(folder_, role.program, std::move(words), kept);
}

void Children::start(Role& role) {
  // a spare that died since the last turn takes over nothing
  if (is_contact_of_hand(role)) reap(spare());
  role.life = {Phase::kStarting, now_ns()};
  if (is_contact_of_hand(role) && spare().child.is_running()) {
    wake_spare_as(role);
  } else {
    launch(role);
  }
  if (&role != &spare()) session_.server.forget_children(role.id, role.generation);
  if (Guarded* const device = device_of(role)) {
    device->guard.watch(role.child.pidfd.get(), role.generation);
  }
}

/// The contact of this role is dead and reaped, so that there is one writer.
void Children::wake_spare_as(Role& contact) {
  if (spare_is_ready()) contact.life.phase = Phase::kWaking;
  const char turn = static_cast<char>(kSpareTurn + static_cast<char>(contact.hand));
  send(turn_.get(), &turn, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
  contact.generation = std::exchange(spare().generation, 0);
  contact.child = std::exchange(spare().child, {});
  spare().life = {};
  session_.server.become(spare().id, contact.generation, contact.id);
}

void Children::reap(const std::function<void(uint32_t hand)>& on_servo_end) {
  for (Role& role : roles_) {
    if (reap(role) && is_servo(role)) on_servo_end(role.hand);
  }
}

bool Children::reap(Role& role) {
  const auto status = role.child.ended();
  if (!status) return false;
  role.child.write_output(session_.log, role.name);
  if (const auto hopeless = role.bury(*status)) {
    session_.log.write(LogLevel::kError, role.name, hopeless->why);
    session_.end(hopeless->exit_code);
    return false;
  }
  const std::string delay = std::to_string(role.put_off(now_ns()) / kMs) + " ms";
  session_.log.write(LogLevel::kWarning, role.name,
                     role.child.how_it_ended(*status) +
                         (&role == &spare()    ? " while it waited; another one in " + delay
                          : lacks_device(role) ? "; starting it again when the device is back"
                                               : "; starting it again in " + delay));
  return true;
}

void Children::start_due(int64_t t_ns) {
  for (Role& role : roles_) {
    if (session_.exit_code || t_ns < start_time(role)) continue;
    try {
      start(role);
    } catch (const std::exception& error) {
      // a lack of descriptors or memory may pass; the session waits
      const bool is_spare = &role == &spare();
      const int64_t wait_ns = is_spare ? role.put_off(t_ns) : kRetryStartNs;
      if (!role.child.is_running()) role.life.phase = Phase::kWaiting;
      role.start_at_ns = t_ns + wait_ns;
      session_.log.write(LogLevel::kError, role.name,
                         (is_spare ? "" : std::string(role.program) + " ") +
                             "cannot be started: " + error.what() + "; trying again in " +
                             std::to_string(wait_ns / kMs) + " ms");
    }
  }
}

/// A spare prepares beside contacts that run.
bool Children::may_have_spare() const {
  return std::ranges::all_of(roles_, [this](const Role& role) {
    return !is_contact_of_hand(role) || role.life.phase == Phase::kRunning;
  });
}

/// When to start a child; never while there is one or its device is gone, and a spare only beside
/// contacts that run.
int64_t Children::start_time(const Role& role) const {
  // what threw after its process had been made runs on
  const bool waits = role.life.phase == Phase::kWaiting && !role.child.is_running() &&
                     !lacks_device(role) && (&role != &spare() || may_have_spare());
  return waits ? role.start_at_ns : Role::kNever;
}

bool Children::spare_is_ready() {
  char word = 0;
  Role& role = spare();
  if (role.life.phase == Phase::kStarting && recv(turn_.get(), &word, 1, MSG_DONTWAIT) == 1 &&
      word == kSpareReady) {
    role.life.phase = Phase::kReady;
  }
  return role.life.phase == Phase::kReady;
}

void Children::look(int64_t t_ns, int64_t held_up_ns) {
  for (Role& role : roles_) {
    role.write_events(session_.log);
    role.watch_pulse(session_.log, t_ns, held_up_ns);
    if (Guarded* const device = device_of(role)) watch_device(role, *device, t_ns);
  }
  tell_what_is_awaited(t_ns);
}

/// Preparing a mesh may take minutes: tells the operator what the session waits for.
void Children::tell_what_is_awaited(int64_t t_ns) {
  if (t_ns - told_waiting_ns_ < kTellWaitingNs) return;
  for (const SessionConfig& config : session_.hands) {
    if (servo_of(config.hand).generation > 0) continue;
    told_waiting_ns_ = t_ns;
    session_.log.write(LogLevel::kInfo, "hapticd",
                       std::string("the servo waits until ") + contact_of(config.hand).name +
                           " has prepared its meshes");
  }
}

/// Waits for a device that is gone; its return gets a new servo that initialises it.
void Children::watch_device(Role& servo, Guarded& device, int64_t t_ns) {
  DeviceGuard& guard = device.guard;
  const DeviceGuard::Change change = guard.look(t_ns);
  if (change == DeviceGuard::Change::kGone) {
    session_.log.write(LogLevel::kWarning, servo.name,
                       guard.path() + ": the device is gone; plug it in again, the session waits");
  } else if (change == DeviceGuard::Change::kBack) {
    session_.log.write(LogLevel::kInfo, servo.name, guard.path() + ": the device is back");
    servo.child.send(SIGTERM);
  }
  if (guard.releases() == device.told_releases) return;
  device.told_releases = guard.releases();
  session_.log.write(LogLevel::kWarning, servo.name,
                     "does not answer: hapticd has let go of the device");
}

void Children::stop() {
  const int64_t begin_ns = now_ns();
  // the servos first: they write the zero wrench while contact and sim still answer
  auto servos = std::views::filter(roles_, [this](const Role& r) { return is_servo(r); });
  for (Role& servo : servos) servo.child.send(SIGTERM);
  for (Role& servo : servos) servo.child.wait_for_exit(begin_ns + kServoStopNs);
  for (const Role& role : roles_) role.child.send(SIGTERM);
  for (Role& role : roles_) {
    if (!role.child.wait_for_exit(begin_ns + kStopNs)) {
      session_.log.write(LogLevel::kWarning, role.name,
                         std::string(role.program) + " did not stop in time and is killed");
      role.child.end();
    }
    role.child.write_output(session_.log, role.name);
  }
  for (Role& role : roles_) role.write_events(session_.log);
}

void Children::report(SessionStatus& status) {
  for (const Role& role : roles_) {
    if (&role == &spare()) continue;
    status.processes.push_back(
        {role.name, role.child.pid, role.generation, role.running() != nullptr});
    if (!is_servo(role)) continue;
    SessionStatus::Hand& hand = status.hands[role.hand];
    hand.runs = role.running() != nullptr;
    if (const Guarded* device = device_of(role)) hand.device += " at " + device->guard.path();
  }
  status.spare = {spare().child.pid, spare().generation, spare_is_ready()};
}

}  // namespace haptic
