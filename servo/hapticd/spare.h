// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/os/programs.h"
#include "servo/hapticd/child_process.h"

namespace haptic {

/// hapticd's side of a prepared contact process that waits until its predecessor is dead. It owns a
/// segment nobody has seen and offers it when told to take over, so two contacts never publish at
/// once and a restart costs a wake-up instead of the start of a process. A spare that dies or does
/// not get ready is replaced, with growing delay.
class Spare {
 public:
  explicit Spare(bool wanted) : wanted_(wanted) {}

  /// Makes the socket pair of the next spare and returns the child's end. Throws std::system_error.
  FileDescriptor connect(int64_t t_ns);

  /// Whether to start a spare now, while a contact runs.
  bool is_due(int64_t t_ns) const noexcept {
    return wanted_ && !process.is_running() && t_ns >= start_at_ns_;
  }
  /// Starts none before t_ns.
  void wait_until(int64_t t_ns) noexcept { start_at_ns_ = t_ns; }
  /// After a spare died while waiting or could not be started: delay before the next one [ns].
  int64_t put_off(int64_t t_ns) noexcept;

  /// Whether it has reported that it waits.
  bool is_ready() noexcept;
  /// Tells the spare to take over and hands out its process; this is then empty. Call it only after
  /// the previous contact has been reaped.
  ChildProcess promote();

  ChildProcess process;
  uint64_t generation = 0;  // of its segment

 private:
  bool wanted_;
  bool ready_ = false;
  FileDescriptor turn_;
  int deaths_in_a_row_ = 0;
  int64_t started_ns_ = 0, start_at_ns_ = 0;
};

}  // namespace haptic
