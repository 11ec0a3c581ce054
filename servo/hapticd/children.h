// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <poll.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "proto/ipc/attachments.h"
#include "servo/hapticd/child_process.h"
#include "servo/hapticd/device_guard.h"
#include "servo/hapticd/role.h"
#include "servo/hapticd/session_run.h"
#include "servo/hapticd/status.h"

namespace haptic {

/// haptic-sim, haptic-contact, haptic-servo and a spare contact: starts them, hands them what they
/// need, restarts what dies, writes what they say into the log, and stops them in the order that
/// ends with a zero wrench. role.h has the states of a child.
///
/// A spare is prepared and sleeps until contact is dead. Its segment is one nobody has seen, which
/// it offers when it is told to take over; so two contacts never publish at once, and a restart
/// costs a wake-up in place of a start.
class Children {
 public:
  /// Opens the device's node, if it has one. Construct it before attachments.start(). Throws
  /// SegmentError, or std::runtime_error if a program or the device is missing.
  Children(SessionRun& session, Attachments& attachments);
  /// Stops them.
  ~Children();
  Children(const Children&) = delete;

  /// Starts the thread that holds the device, after attachments.start().
  void guard_device();
  /// Starts sim and contact; the servo comes once contact has offered its segment, because a hand
  /// must not enter an object whose mesh is still being read.
  void start();
  void take_offer(const Announcement& offer);

  static constexpr size_t kRoles = 4, kWaits = 2 * kRoles;
  /// Writes what poll() is to wait for; returns when the next child is to be started.
  int64_t wait_for(std::span<pollfd, kWaits> waiting) const;
  /// Logs what they have said.
  void write_output();
  /// Buries the dead. A servo that is to be followed by another one is told to on_servo_end.
  void reap(const std::function<void()>& on_servo_end);
  void start_due(int64_t t_ns);
  /// Looks at events, heartbeats, spare and device. To be called regularly, held_up_ns later than
  /// planned.
  void look(int64_t t_ns, int64_t held_up_ns);
  void stop();
  /// Fills in what the status says of them.
  void report(SessionStatus& status);

 private:
  /// True of the servo of a device with a node, which hapticd holds too.
  bool drives(const Role& role) const { return guard_.has_value() && &role == &servo_; }
  /// True while the device of a servo is gone: it is not started until the device is back.
  bool lacks_device(const Role& role) const { return drives(role) && guard_->node() < 0; }
  int64_t start_time(const Role& role) const;
  void start(Role& role);
  void launch(Role& role);
  /// Buries a child that has ended; true if another one is to follow it.
  bool reap(Role& role);
  bool spare_is_ready();
  void watch_device(int64_t t_ns);

  SessionRun& session_;
  const std::string folder_;  // of the programs
  FileDescriptor config_file_;
  std::map<SegmentId, uint64_t> newest_generation_;
  std::array<Role, kRoles> roles_;  // in the order of starting
  Role& sim_ = roles_[0];
  Role& contact_ = roles_[1];
  Role& servo_ = roles_[2];
  Role& spare_ = roles_[3];
  FileDescriptor turn_;  // to tell the spare that it is contact now
  std::optional<DeviceGuard> guard_;
  uint64_t told_releases_ = 0;
  int64_t told_waiting_ns_ = 0;
};

}  // namespace haptic
