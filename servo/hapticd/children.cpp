// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/children.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
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
constexpr HandNames kSpareNames = names_of_hands("contact", " spare");

template <typename Channels>
Role role_of(const char* program, double rate, Attachments& attachments) {
  return {program,         Channels::kName,  Channels::kId,
          period_ns(rate), restart_delay_ns, attachments.ring<&Channels::events>(Start::kOldest)};
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
      config_file_(make_sealed_file("haptic-config", std::as_bytes(std::span(&session.config, 1)))),
      roles_{
          role_of<SimChannels>("haptic-sim", session.config.sim_rate, attachments),
          role_of<ContactChannels>("haptic-contact", session.config.contact_poll_rate, attachments),
          role_of<ServoChannels>("haptic-servo", session.config.servo_rate, attachments),
          {"haptic-contact", kSpareNames[kFirstHand].data(), ContactChannels::kId,
           period_ns(session.config.contact_poll_rate), spare_delay_ns}} {
  if (row_of(session.config.device.kind).has_node()) guard_.emplace(session.config, attachments);
  for (const Role& role : roles_) {
    const std::string path = folder_ + "/" + role.program;
    if (access(path.c_str(), X_OK) != 0) throw std::runtime_error(cannot_start(path, errno));
  }
}

Children::~Children() {
  stop();
}

void Children::guard_device() {
  if (guard_) guard_->start();
}

void Children::start() {
  start(sim_);
  start(contact_);
  told_waiting_ns_ = now_ns();
}

void Children::take_offer(const Announcement& offer) {
  for (Role& role : roles_) {
    const bool is_its = role.id == offer.id && role.generation == offer.generation;
    if (is_its && role.life.phase != Phase::kWaiting) role.life.phase = Phase::kRunning;
  }
  if (offer.id != contact_.id) return;
  if (servo_.generation == 0) servo_.start_at_ns = 0;
  if (session_.config.contact_spare != 0) spare_.start_at_ns = now_ns() + kSpareAfterNs;
}

int64_t Children::wait_for(std::span<pollfd, kWaits> waiting) const {
  int64_t next_ns = Role::kNever;
  for (size_t i = 0; i < kRoles; ++i) {
    const ChildProcess& child = roles_[i].child;
    // poll ignores the −1 of a process that does not run
    waiting[2 * i] = {child.pidfd.get(), POLLIN, 0};
    waiting[2 * i + 1] = {child.output.get(), POLLIN, 0};
    next_ns = std::min(next_ns, start_time(roles_[i]));
  }
  return next_ns;
}

void Children::write_output() {
  for (Role& role : roles_) role.child.write_output(session_.log, role.name);
}

void Children::launch(Role& role) {
  role.generation = ++newest_generation_[role.id];
  const FileDescriptor socket = session_.server.connect_child(role.id, role.generation);
  const FileDescriptor turn = &role == &spare_ ? connect_spare(turn_) : FileDescriptor();
  const std::pair<const char*, int> handed[] = {
      {"--config-fd", config_file_.get()},
      {"--control-fd", socket.get()},
      {"--device-fd", drives(role) ? guard_->node_for_servo() : -1},
      {"--spare-fd", turn.get()}};
  std::vector<std::string> words;
  std::vector<int> kept;
  for (const auto& [key, fd] : handed) {
    if (fd < 0) continue;
    words.insert(words.end(), {key, std::to_string(fd)});
    kept.push_back(fd);
  }
  words.insert(words.end(), {"--generation", std::to_string(role.generation)});
  role.child.launch(folder_, role.program, std::move(words), kept);
}

void Children::start(Role& role) {
  // a spare that died since the last turn takes over nothing
  if (&role == &contact_) reap(spare_);
  role.life = {Phase::kStarting, now_ns()};
  if (&role == &contact_ && spare_.child.is_running()) {
    // contact is dead and reaped, so that there is one writer
    if (spare_is_ready()) role.life.phase = Phase::kWaking;
    send(turn_.get(), &kSpareTurn, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
    role.generation = std::exchange(spare_.generation, 0);
    role.child = std::exchange(spare_.child, {});
    spare_.life = {};
  } else {
    launch(role);
  }
  if (&role != &spare_) session_.server.forget_children(role.id, role.generation);
  if (drives(role)) guard_->watch(role.child.pidfd.get(), role.generation);
}

void Children::reap(const std::function<void()>& on_servo_end) {
  for (Role& role : roles_) {
    if (reap(role) && &role == &servo_) on_servo_end();
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
                         (&role == &spare_     ? " while it waited; another one in " + delay
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
      const bool is_spare = &role == &spare_;
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

/// When to start a child; never while there is one or its device is gone, and a spare only beside a
/// contact that runs.
int64_t Children::start_time(const Role& role) const {
  // what threw after its process had been made runs on
  const bool waits = role.life.phase == Phase::kWaiting && !role.child.is_running() &&
                     !lacks_device(role) &&
                     (&role != &spare_ || contact_.life.phase == Phase::kRunning);
  return waits ? role.start_at_ns : Role::kNever;
}

bool Children::spare_is_ready() {
  char word = 0;
  if (spare_.life.phase == Phase::kStarting && recv(turn_.get(), &word, 1, MSG_DONTWAIT) == 1 &&
      word == kSpareReady) {
    spare_.life.phase = Phase::kReady;
  }
  return spare_.life.phase == Phase::kReady;
}

void Children::look(int64_t t_ns, int64_t held_up_ns) {
  for (Role& role : roles_) {
    role.write_events(session_.log);
    role.watch_pulse(session_.log, t_ns, held_up_ns);
  }
  if (guard_) watch_device(t_ns);
  // preparing a mesh may take minutes: tells the operator what the session waits for
  if (servo_.generation > 0 || t_ns - told_waiting_ns_ < kTellWaitingNs) return;
  told_waiting_ns_ = t_ns;
  session_.log.write(
      LogLevel::kInfo, "hapticd",
      std::string("the servo waits until ") + contact_.name + " has prepared its meshes");
}

/// Waits for a device that is gone; its return gets a new servo that initialises it.
void Children::watch_device(int64_t t_ns) {
  const DeviceGuard::Change change = guard_->look(t_ns);
  if (change == DeviceGuard::Change::kGone) {
    session_.log.write(
        LogLevel::kWarning, servo_.name,
        guard_->path() + ": the device is gone; plug it in again, the session waits");
  } else if (change == DeviceGuard::Change::kBack) {
    session_.log.write(LogLevel::kInfo, servo_.name, guard_->path() + ": the device is back");
    servo_.child.send(SIGTERM);
  }
  if (guard_->releases() == told_releases_) return;
  told_releases_ = guard_->releases();
  session_.log.write(LogLevel::kWarning, servo_.name,
                     "does not answer: hapticd has let go of the device");
}

void Children::stop() {
  const int64_t begin_ns = now_ns();
  // the servo first: it writes the zero wrench while contact and sim still answer
  servo_.child.send(SIGTERM);
  servo_.child.wait_for_exit(begin_ns + kServoStopNs);
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
  if (guard_) status.device += " at " + guard_->path();
  for (const Role* role : {&sim_, &contact_, &servo_}) {
    status.processes.push_back(
        {role->name, role->child.pid, role->generation, role->running() != nullptr});
  }
  status.spare = {spare_.child.pid, spare_.generation, spare_is_ready()};
}

}  // namespace haptic
