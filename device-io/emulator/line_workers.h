// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <thread>

namespace haptic {

/// The bytes of a pseudo-terminal are carried by kernel threads of normal priority (kworker/u…),
/// those of a real device by interrupts. On a machine whose processors are busy the line would
/// stand still, and nobody could tell what a server does about it. While this lives, these threads
/// have real-time priority, where the process may give it (CAP_SYS_NICE); afterwards they have what
/// they had. It looks for new ones every 50 ms.
class LineWorkers {
 public:
  explicit LineWorkers(int fifo_priority);
  ~LineWorkers();
  LineWorkers(const LineWorkers&) = delete;

 private:
  void run();

  int fifo_priority_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace haptic
