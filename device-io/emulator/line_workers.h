// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <thread>

namespace haptic {

/// Gives real-time priority to the kernel threads (kworker/u…) that carry the bytes of a
/// pseudo-terminal, if the process may (CAP_SYS_NICE). A real device's bytes are carried by
/// interrupts; these threads have normal priority, so on a busy machine the line would stall
/// whatever the server does. Looks for new threads every 50 ms; the destructor restores their
/// priority.
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
