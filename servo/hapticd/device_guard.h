// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "proto/config/config.h"
#include "proto/ipc/handout.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// When the bytes of a release are due: at once, and some times more, because a packet may collide
/// with one of the dying servo. Begins anew once the servo has been well again.
class ReleaseSchedule {
 public:
  static constexpr int kTimes = 4;
  static constexpr int64_t kApartNs = 5'000'000;

  /// Whether to send now, given whether the servo is dead or silent at present.
  bool is_due(bool helpless, int64_t t_ns);

 private:
  int sent_ = 0;
  int64_t next_ns_ = 0;
};

/// hapticd's own hold on a device with a node (design.md §6). It opens the node before the servo
/// starts and keeps it open; a thread at FIFO 90 watches the servo's pidfd and heartbeat and, when
/// it died or missed kReleaseAfterTicks, writes the servo's own bytes for no force: at the device
/// within 20 ms. Where the guard itself was held up, so was the servo: the look after that judges.
/// A node that hung up is closed and opened again as soon as the device is back.
class DeviceGuard {
 public:
  /// Opens the node. To be made before attachments.start(). Throws std::runtime_error, one line.
  DeviceGuard(const SessionConfig& config, Attachments& attachments);
  ~DeviceGuard();
  DeviceGuard(const DeviceGuard&) = delete;

  /// Starts the thread; without the rights for FIFO at normal priority.
  void start();

  /// The open node, to be inherited by a servo; −1 while the device is gone.
  int node() const { return node_.get(); }

  /// From now on this servo is watched.
  void watch(int pidfd, uint64_t generation);

  enum class Change { kNone, kGone, kBack };
  /// Once in a while: whether the device went or came back. After kBack the servo needs the new
  /// node, so it must be started anew.
  Change look(int64_t t_ns);

  /// Times the device was let go because its servo was dead or silent.
  uint64_t releases() const { return releases_.load(std::memory_order_relaxed); }
  const std::string& path() const { return path_; }

 private:
  /// What the thread watches; handed over whole.
  struct Watched {
    FileDescriptor node, pidfd;
    uint64_t generation = 0;
  };

  void run();
  void hand_over();
  bool adopt(std::unique_ptr<Watched>& watched);
  bool is_helpless(const Watched& watched, int64_t t_ns) noexcept;
  bool release(const Watched& watched) noexcept;

  std::string path_;
  int64_t period_ns_;
  bool realtime_;
  FileDescriptor node_, pidfd_;
  uint64_t generation_ = 0;
  int64_t try_again_ns_ = 0;

  RingSource<&ServoChannels::releases> offered_;  // from here on of the thread
  DeviceRelease release_{};
  std::atomic<Watched*> next_{nullptr};
  std::atomic<uint64_t> releases_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace haptic
