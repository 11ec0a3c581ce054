// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <poll.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/ipc/attachments.h"
#include "servo/hapticd/child_process.h"
#include "servo/hapticd/device_guard.h"
#include "servo/hapticd/role.h"
#include "servo/hapticd/session_run.h"
#include "servo/hapticd/status.h"

namespace haptic {

/// haptic-sim, for each hand haptic-contact and haptic-servo, and a spare contact: starts them,
/// hands them what they need, restarts what dies, writes what they say into the log, and stops them
/// in the order that ends with a zero wrench. role.h has the states of a child.
///
/// The spare is prepared for every hand and sleeps until a contact is dead. Its segments are ones
/// nobody has seen, of which it offers the dead one's when it is told to take over; so two contacts
/// of a hand never publish at once, and a restart costs a wake-up in place of a start.
class Children {
 public:
  /// Opens the nodes of the devices that have one. Construct it before attachments.start(). Throws
  /// SegmentError, or std::runtime_error if a program or a device is missing.
  Children(SessionRun& session, Attachments& attachments);
  /// Stops them.
  ~Children();
  Children(const Children&) = delete;

  /// Starts the threads that hold the devices, after attachments.start().
  void guard_devices();
  /// Starts sim and the contacts; a servo comes once the contact of its hand has offered its
  /// segment, because a hand must not enter an object whose mesh is still being read.
  void start();
  void take_offer(const Announcement& offer);

  static constexpr size_t kMostRoles = 2 + 2 * kMostHands, kWaits = 2 * kMostRoles;
  /// Writes what poll() is to wait for; returns when the next child is to be started.
  int64_t wait_for(std::span<pollfd, kWaits> waiting) const;
  /// Logs what they have said.
  void write_output();
  /// Buries the dead. The hand of a servo that is to be followed by another one is told to
  /// on_servo_end.
  void reap(const std::function<void(uint32_t hand)>& on_servo_end);
  void start_due(int64_t t_ns);
  /// Looks at events, heartbeats, spare and devices. To be called regularly, held_up_ns later than
  /// planned.
  void look(int64_t t_ns, int64_t held_up_ns);
  void stop();
  /// Fills in what the status says of them.
  void report(SessionStatus& status);

 private:
  /// A device with a node, which hapticd guards.
  struct Guarded {
    explicit Guarded(const SessionConfig& config, Attachments& attachments)
        : guard(config, attachments) {}
    DeviceGuard guard;
    uint64_t told_releases = 0;
  };

  Role& contact_of(uint32_t hand) { return roles_[1 + 2 * hand]; }
  Role& servo_of(uint32_t hand) { return roles_[2 + 2 * hand]; }
  bool is_servo(const Role& role) const { return role.id == servo_segment(role.hand); }
  bool is_contact_of_hand(const Role& role) const {
    return is_contact(role.id) && &role != &spare();
  }
  Role& spare() { return roles_.back(); }
  const Role& spare() const { return roles_.back(); }
  /// The device that a servo drives, if it has a node, which hapticd holds too; else null.
  Guarded* device_of(const Role& role) const {
    return is_servo(role) ? devices_[role.hand].get() : nullptr;
  }
  /// True while the device of a servo is gone: it is not started until the device is back.
  bool lacks_device(const Role& role) const {
    const Guarded* device = device_of(role);
    return device != nullptr && device->guard.node() < 0;
  }
  bool may_have_spare() const;
  int64_t start_time(const Role& role) const;
  void start(Role& role);
  void launch(Role& role);
  void wake_spare_as(Role& contact);
  /// The number of the next writer of a segment; a spare's is new for every hand.
  uint64_t next_generation(const Role& role);
  /// Buries a child that has ended; true if another one is to follow it.
  bool reap(Role& role);
  bool spare_is_ready();
  void watch_device(Role& servo, Guarded& device, int64_t t_ns);
  void tell_what_is_awaited(int64_t t_ns);

  SessionRun& session_;
  const std::string folder_;  // of the programs
  FileDescriptor config_file_;
  std::map<SegmentId, uint64_t> newest_generation_;
  std::vector<Role> roles_;  // sim, for each hand contact and servo, the spare
  FileDescriptor turn_;      // to tell the spare whose contact it is now
  std::vector<std::unique_ptr<Guarded>> devices_;  // by hand; null: one without a node
  int64_t told_waiting_ns_ = 0;
};

}  // namespace haptic
