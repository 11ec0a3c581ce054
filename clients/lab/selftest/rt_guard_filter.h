// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ucontext.h>

#include <memory>

/// System calls of a guarded thread: those the filter allows, and those the guard itself needs
/// behind it.
namespace haptic::detail {

/// Allows the deadline sleep (clock_nanosleep until an instant of CLOCK_MONOTONIC), the two clocks
/// the project reads, the thread's getrusage, reads and writes of the device's node, the return
/// from a signal, the end of the thread, and the guard's own calls. All others raise SIGSYS.
class SystemCallFilter {
 public:
  /// `device_node`: an open descriptor; −1: none. Throws std::system_error.
  explicit SystemCallFilter(int device_node);

  /// Filters the calling thread for the rest of its life. Throws std::system_error.
  void load();

 private:
  std::unique_ptr<void, void (*)(void*)> filter_;
};

/// A refused system call, as seen by the handler of SIGSYS.
class RefusedCall {
 public:
  explicit RefusedCall(void* context) : context_(*static_cast<ucontext_t*>(context)) {}

  long number() const noexcept;
  long argument(int i) const noexcept;
  /// Result for the caller; without it, whatever the register held.
  void set_result(long result) noexcept;
  /// True if it waits for or releases a lock: if that fails, the C library ends the program.
  bool is_lock() const noexcept;
  /// True if it raises SIGABRT.
  bool is_abort() const noexcept;
  /// Makes the call if the guard itself needs it; else ENOSYS.
  long make() const noexcept;

 private:
  ucontext_t& context_;
};

/// A call of the guard's own; negative results are errors, errno is unchanged. Only for the handler
/// of SIGSYS, whose return restores the registers, or before an abort: the password that passes the
/// filter stays in a register.
long call_past_filter(long number, long a = 0, long b = 0, long c = 0, long d = 0,
                      long f = 0) noexcept;

}  // namespace haptic::detail
