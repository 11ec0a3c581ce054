// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/os/programs.h"
#include "servo/hapticd/child_process.h"

namespace haptic {

/// hapticd's side of a contact that has prepared everything and waits until its predecessor is
/// dead: it owns a segment that nobody has seen, and offers it when it is told that its turn has
/// come. So two contacts are never heard at once, and a restart costs a wake-up instead of the
/// start of a process. One that dies or does not get ready is replaced, later each time.
class Spare {
 public:
  explicit Spare(bool wanted) : wanted_(wanted) {}

  /// A socket pair for the next one: the child's end, to be inherited. Throws std::system_error.
  FileDescriptor connect(int64_t t_ns);

  /// Whether one should be started now, beside a contact that runs.
  bool is_due(int64_t t_ns) const noexcept {
    return wanted_ && !process.is_running() && t_ns >= start_at_ns_;
  }
  /// No other before that.
  void wait_until(int64_t t_ns) noexcept { start_at_ns_ = t_ns; }
  /// It died while it waited, or could not be started; returns how long the next one waits [ns].
  int64_t put_off(int64_t t_ns) noexcept;

  /// Whether it has said that it waits.
  bool is_ready() noexcept;
  /// Its turn: from now on it is a contact like any other, and this is empty. To be called when the
  /// contact before it has been reaped.
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
