// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "proto/config/config.h"
#include "proto/ipc/attachments.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// When to send the release bytes: at once and three times more, since a packet may collide with
/// one of the dying servo. Starts again once the servo has recovered.
class ReleaseSchedule {
 public:
  static constexpr int kTimes = 4;
  static constexpr int64_t kApartNs = 5'000'000;

  /// True if the bytes are to be sent now; `helpless`: the servo is dead or silent at present.
  bool is_due(bool helpless, int64_t t_ns);

 private:
  int sent_ = 0;
  int64_t next_ns_ = 0;
};

/// Lets go of a device with a node when its servo fails. Opens the node before the servo starts and
/// keeps it open. A thread at FIFO 90 watches the servo's pidfd and heartbeat; when the servo has
/// died or missed kReleaseAfterTicks ticks, it writes the servo's own bytes for zero force, which
/// reach the device within 20 ms. A check that comes late is skipped: what held up the guard may
/// have held up the servo. A node that hung up is closed, and opened again when the device is back.
class DeviceGuard {
 public:
  /// Opens the node. Construct it before attachments.start(). Throws std::runtime_error, one line.
  DeviceGuard(const SessionConfig& config, Attachments& attachments);
  ~DeviceGuard();
  DeviceGuard(const DeviceGuard&) = delete;

  /// Starts the thread; without the right to FIFO it runs at normal priority.
  void start();

  /// The open node; −1 while the device is gone.
  int node() const { return node_.get(); }

  /// The node for a new servo to inherit, while the device is there. That of a USB device is opened
  /// anew for each servo: it would reap the finished transfers of the one before, whose data the
  /// kernel writes to addresses in the dead one's memory. Waits a little for the thread to let go
  /// of the old one, whose claim would keep the new servo out. Throws std::runtime_error if it
  /// cannot be opened: a servo without it would open one that nobody guards.
  int node_for_servo();

  /// Watches this servo from now on.
  void watch(int pidfd, uint64_t generation);

  enum class Change { kNone, kGone, kBack };
  /// Tells of a device that has gone or come back; to be called regularly. After kBack the servo
  /// must be restarted with the new node.
  Change look(int64_t t_ns);

  /// Number of times the device was released because its servo was dead or silent.
  uint64_t releases() const { return releases_.load(std::memory_order_relaxed); }
  const std::string& path() const { return path_; }

 private:
  /// The descriptors that the thread watches, exchanged as a whole.
  struct Watched {
    FileDescriptor node, pidfd;
    uint64_t generation = 0;
  };

  void run();
  void hand_over();
  bool is_helpless(const Watched& watched, int64_t t_ns) noexcept;

  DeviceConfig device_;
  std::string path_;
  int64_t period_ns_;
  bool realtime_;
  FileDescriptor node_, pidfd_;
  uint64_t generation_ = 0;
  int64_t try_again_ns_ = 0;

  RingSource<&ServoChannels::releases> offered_;  // used by the thread alone, like release_
  DeviceRelease release_{};
  std::atomic<Watched*> next_{nullptr};
  std::atomic<uint64_t> releases_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace haptic
