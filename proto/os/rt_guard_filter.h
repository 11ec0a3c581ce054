// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ucontext.h>

#include <memory>

/// The system calls of a guarded thread: what the kernel lets through, and what the guard itself
/// still needs behind its own filter.
namespace haptic::detail {

/// Lets through the deadline sleep (clock_nanosleep until an instant of CLOCK_MONOTONIC), the two
/// clocks the project reads, the thread's own getrusage, reads and writes of the device's node, the
/// return from a signal, the end of the thread, and the guard's own calls. Every other call becomes
/// SIGSYS.
class SystemCallFilter {
 public:
  /// `device_node`: an open descriptor, or -1: none. Throws std::system_error.
  explicit SystemCallFilter(int device_node);

  /// For the calling thread, and for the rest of its life. Throws std::system_error.
  void load();

 private:
  std::unique_ptr<void, void (*)(void*)> filter_;
};

/// A system call that was refused, as the handler of SIGSYS finds it.
class RefusedCall {
 public:
  explicit RefusedCall(void* context) : context_(*static_cast<ucontext_t*>(context)) {}

  long number() const noexcept;
  long argument(int i) const noexcept;
  /// Without it the caller takes what the register held.
  void set_result(long result) noexcept;
  /// Whether it is a wait for a lock or its end: the C library ends the program when that fails.
  bool is_lock() const noexcept;
  /// Whether it raises SIGABRT.
  bool is_abort() const noexcept;
  /// Makes it after all, where it is one of those the guard itself needs; ENOSYS where not.
  long make() const noexcept;

 private:
  ucontext_t& context_;
};

/// A call of the guard's own; a negative result is an error, errno stays as it was. Only from the
/// handler of SIGSYS, whose return restores the registers, or on the way to an abort: the password
/// that lets it through stays in a register.
long call_past_filter(long number, long a = 0, long b = 0, long c = 0, long d = 0,
                      long f = 0) noexcept;

}  // namespace haptic::detail
