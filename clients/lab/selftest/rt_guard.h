// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/resource.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

/// Checks that a loop does nothing that may block: armed after warm-up, it catches forbidden
/// actions of the thread by interposed libc functions (clients/lab/selftest/rt_guard_hooks.cpp,
/// linked only into test programs), a seccomp filter on system calls, and the kernel's counts of
/// page faults.
///
/// Not seen: an uncontended lock inside the C library, such as that of a FILE in a buffered fputc
/// or fprintf. A contended one shows as a system call.
namespace haptic {

namespace detail {
class SystemCallFilter;
}

enum class Violation : uint32_t {
  kAllocate,    // malloc, calloc, realloc, memalign and its kin; operator new through them
  kFree,        // free; operator delete through it
  kMutex,       // mutex (pthread or C11), spin lock or semaphore: taken, tried or waited for
  kCondition,   // pthread_cond_wait, timedwait, clockwait, signal, broadcast
  kRwlock,      // pthread_rwlock_rdlock, wrlock, each also try, timed and clock
  kSystemCall,  // not on the list; refused with ENOSYS, except futex, which is made
  kMinorFault,  // page fault served without reading from disk
  kMajorFault,  // page fault that read from disk
};
inline constexpr size_t kViolations = 8;  // kept of a run; one is enough to fail

/// "allocation", "system call", …
const char* name_of(Violation kind) noexcept;

/// Count of one kind, and the stack of the first. Faults have no stack.
struct Caught {
  static constexpr int kMaxDepth = 24;
  uint64_t count = 0;
  int depth = 0;
  std::array<void*, kMaxDepth> stack{};
};

struct GuardReport {
  std::array<Caught, kViolations> caught{};
  int first_system_call = -1;         // number of the first refused one
  uint64_t involuntary_switches = 0;  // caused by the machine, not the loop: no violation
  uint64_t voluntary_switches = 0;    // one per sleep; the loop's owner knows how many it meant

  const Caught& of(Violation kind) const { return caught[static_cast<size_t>(kind)]; }
  Caught& of(Violation kind) { return caught[static_cast<size_t>(kind)]; }
  uint64_t violations() const noexcept;
  /// The first of each kind with its stack; one line each, empty if clean.
  std::string explain() const;
};

/// True if the interposed functions are linked into this program.
bool guard_hooks_linked() noexcept;

struct GuardOptions {
  bool filter_system_calls = true;
  int device_node = -1;        // descriptor the loop may read and write; -1: none
  bool abort_at_once = false;  // print kind and stack, then abort, instead of counting
};

/// Guards the thread that makes it, from arm() to disarm(). The first arm() loads the filter for
/// the rest of the thread's life, so use a separate thread. Allowed are the deadline sleep (until
/// an instant of CLOCK_MONOTONIC), getrusage of the thread, reading the clock (no system call where
/// the kernel maps it), the device's node, the return from a signal and the end of the thread.
/// Refused calls count from then on, armed or not. A thread that aborts says so first. One guard
/// per thread.
class RtGuard {
 public:
  /// Throws std::system_error if a filter cannot be made.
  explicit RtGuard(const GuardOptions& options = {});
  ~RtGuard();
  RtGuard(const RtGuard&) = delete;

  /// Throws std::system_error if the kernel refuses the filter.
  void arm();
  void disarm() noexcept;

  /// Sum over all armed periods.
  const GuardReport& report() const noexcept { return report_; }

 private:
  std::unique_ptr<detail::SystemCallFilter> filter_;
  bool is_filtered_ = false;
  GuardReport report_;
  rusage armed_at_{};
};

/// How often some work allocates and frees.
uint64_t allocations_of(const auto& work) {
  RtGuard guard({.filter_system_calls = false});
  guard.arm();
  work();
  guard.disarm();
  return guard.report().of(Violation::kAllocate).count + guard.report().of(Violation::kFree).count;
}

namespace detail {
/// Called by a hook: counts if the calling thread is armed.
void note_violation(Violation kind) noexcept;
/// Called once by the hooks' object file, for guard_hooks_linked().
void note_hooks_linked() noexcept;
}  // namespace detail

}  // namespace haptic
