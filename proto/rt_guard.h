// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

/// Proof that a loop does nothing that may block: armed after warm-up, it catches what the thread
/// must not do. Three witnesses: interposed libc functions (proto/rt_guard_hooks.cpp, which only
/// programs that prove something link), a seccomp filter on system calls, and the kernel's counts
/// of page faults.
namespace haptic {

enum class Violation : uint32_t {
  kAllocate,    // malloc, calloc, realloc, posix_memalign, aligned_alloc; operator new through them
  kFree,        // free; operator delete through it
  kMutex,       // pthread_mutex_lock, trylock, timedlock, clocklock
  kCondition,   // pthread_cond_wait, timedwait, clockwait, signal, broadcast
  kRwlock,      // pthread_rwlock_rdlock, wrlock, tryrdlock, trywrlock
  kSystemCall,  // one that is not on the list; it is refused with ENOSYS
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
  uint64_t voluntary_switches = 0;    // a sleep each

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
  bool abort_at_once = false;  // print kind and stack, then abort, instead of counting
};

/// Guards the thread that makes it, from arm() to disarm(). The filter lets through the deadline
/// sleep, the clock (no system call where the kernel maps it), getrusage for the counts, the return
/// from a signal and the end of the thread; it stays for the rest of the thread's life, so use a
/// thread of its own. One guard a thread. Throws std::system_error where there is no seccomp.
class RtGuard {
 public:
  explicit RtGuard(const GuardOptions& options = {});
  ~RtGuard();
  RtGuard(const RtGuard&) = delete;

  void arm() noexcept;
  void disarm() noexcept;

  /// Adds up over all armed stretches.
  const GuardReport& report() const noexcept { return report_; }

 private:
  struct Usage {
    int64_t minor_faults, major_faults, involuntary_switches, voluntary_switches;
  };
  static Usage read_usage() noexcept;

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
