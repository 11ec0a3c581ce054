// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

/// Proof that a loop does nothing that may block: armed after warm-up, it catches what the thread
/// must not do. Three witnesses: interposed libc functions (proto/os/rt_guard_hooks.cpp, which only
/// programs that prove something link), a seccomp filter on system calls, and the kernel's counts
/// of page faults.
///
/// Not seen: a lock that the C library takes within itself while nobody else holds it, such as that
/// of a FILE in a buffered fputc or fprintf. Where somebody does, the wait is a system call.
namespace haptic {

namespace detail {
class SystemCallFilter;
}

enum class Violation : uint32_t {
  kAllocate,    // malloc, calloc, realloc, memalign and its kin; operator new through them
  kFree,        // free; operator delete through it
  kMutex,       // a mutex of pthread or C11, a spin lock, a semaphore: taken, tried or waited for
  kCondition,   // pthread_cond_wait, timedwait, clockwait, signal, broadcast
  kRwlock,      // pthread_rwlock_rdlock, wrlock, each also try, timed and clock
  kSystemCall,  // one that is not on the list; it is refused with ENOSYS, but a futex is made
  kMinorFault,  // a page was not there and could be given without reading
  kMajorFault,  // a page was not there and was read
};
inline constexpr size_t kViolations = 8;

/// "allocation", "system call", …
const char* name_of(Violation kind) noexcept;

/// What was caught of one kind, and from where the first time. Faults have no stack.
struct Caught {
  static constexpr int kMaxDepth = 24;
  uint64_t count = 0;
  int depth = 0;
  std::array<void*, kMaxDepth> stack{};
};

struct GuardReport {
  std::array<Caught, kViolations> caught{};
  int first_system_call = -1;         // number of the first that was refused
  uint64_t involuntary_switches = 0;  // the machine's doing, not the loop's: no violation
  uint64_t voluntary_switches = 0;    // a sleep each; the owner of the loop knows how many it meant

  const Caught& of(Violation kind) const { return caught[static_cast<size_t>(kind)]; }
  Caught& of(Violation kind) { return caught[static_cast<size_t>(kind)]; }
  uint64_t violations() const noexcept;
  /// The first of each kind, with the functions on its stack; one line each, empty when clean.
  std::string explain() const;
};

/// Whether the interposed functions are linked into this program.
bool guard_hooks_linked() noexcept;

struct GuardOptions {
  bool filter_system_calls = true;
  int device_node = -1;        // descriptor the loop may read and write; -1: none
  bool abort_at_once = false;  // print kind and stack, then abort, instead of counting
};

/// Guards the thread that makes it, from arm() to disarm(). The first arm() loads the filter, which
/// stays for the rest of the thread's life, so use a thread of its own. It lets through the
/// deadline sleep (until an instant of CLOCK_MONOTONIC, no other), getrusage of the thread, a look
/// at the clock (no system call where the kernel maps it), the device's node, the return from a
/// signal and the end of the thread. What it refuses is counted from then on, armed or not. A
/// thread that aborts says so first. One guard a thread.
class RtGuard {
 public:
  /// Throws std::system_error where a filter cannot be made.
  explicit RtGuard(const GuardOptions& options = {});
  ~RtGuard();
  RtGuard(const RtGuard&) = delete;

  /// Throws std::system_error where the kernel refuses the filter.
  void arm();
  void disarm() noexcept;

  /// Adds up over all armed stretches.
  const GuardReport& report() const noexcept { return report_; }

 private:
  struct Usage {
    int64_t minor_faults, major_faults, involuntary_switches, voluntary_switches;
  };
  static Usage read_usage() noexcept;

  std::unique_ptr<detail::SystemCallFilter> filter_;
  bool is_filtered_ = false;
  GuardReport report_;
  Usage armed_at_{};
};

namespace detail {
/// From a hook: counts it if the calling thread is armed.
void note_violation(Violation kind) noexcept;
/// Called once by the hooks' object, so that guard_hooks_linked() can tell.
void note_hooks_linked() noexcept;
}  // namespace detail

}  // namespace haptic
