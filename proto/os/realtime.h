// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <time.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

/// Clocks, absolute deadlines, and the rights a periodic thread needs.
namespace haptic {

inline constexpr int64_t kNsPerSecond = 1'000'000'000;

/// Reading of a clock [ns].
inline int64_t read_clock_ns(clockid_t clock) noexcept {
  timespec t;
  clock_gettime(clock, &t);
  return int64_t{t.tv_sec} * kNsPerSecond + t.tv_nsec;
}

/// CLOCK_MONOTONIC [ns]: the clock of every deadline and every t_ns.
inline int64_t now_ns() noexcept {
  return read_clock_ns(CLOCK_MONOTONIC);
}

/// CLOCK_REALTIME [ns] since 1970: for recordings only, since it may jump.
inline int64_t realtime_now_ns() noexcept {
  return read_clock_ns(CLOCK_REALTIME);
}

/// Period [ns] of a rate [Hz].
inline int64_t period_ns(double rate) noexcept {
  return std::llround(static_cast<double>(kNsPerSecond) / rate);
}

/// Sleeps until an instant of CLOCK_MONOTONIC; signals do not cut it short.
void sleep_until(int64_t deadline_ns) noexcept;

/// One wake-up on the grid.
struct Tick {
  uint64_t index;       // grid point; skipped ones leave a gap
  int64_t deadline_ns;  // the instant of that grid point, CLOCK_MONOTONIC
  int64_t late_ns;      // wake-up after the deadline
  uint64_t skipped;     // grid points skipped since the clock was made
};

/// Grid point to wake at after grid point `last`, at time `now_ns`: the next one or, if that is
/// past, the first still to come. Grid point i is at start + i·period.
uint64_t next_grid_point(int64_t start_ns, int64_t period, uint64_t last, int64_t now_ns) noexcept;

/// Spinning time of a hybrid clock before a grid point [ns].
inline constexpr int64_t kHybridSpinNs = 100'000;

/// Absolute grid on CLOCK_MONOTONIC. Missed grid points are skipped and counted; ticks are never
/// run in a burst to catch up. Grid point 0 is one period after construction.
class DeadlineClock {
 public:
  /// `spin_ns` > 0: hybrid, sleeps until that long before each grid point, then spins; at most half
  /// a period, which leaves the rest to other threads.
  explicit DeadlineClock(int64_t period, int64_t spin_ns = 0) noexcept;

  /// Sleeps until the next grid point. No allocation; one system call.
  Tick wait() noexcept;

  /// Moves the grid, before the first wait().
  void start_at(int64_t start_ns) noexcept { start_ns_ = start_ns; }

  int64_t period() const noexcept { return period_; }

 private:
  int64_t period_;
  int64_t spin_ns_;
  int64_t start_ns_;
  uint64_t next_ = 0;  // first grid point not yet used
  uint64_t skipped_ = 0;
};

/// Stack of the threads that this process makes from here on, 512 KiB: locked memory holds all of a
/// stack, touched or not, and the usual one is 8 MiB. Call it before the first thread.
void use_small_thread_stacks() noexcept;

/// Real-time rights, as bits in a segment's header.
enum RealtimeBit : uint32_t {
  kRealtimeWanted = 1u << 0,        // requested by the session
  kRealtimeFifo = 1u << 1,          // SCHED_FIFO granted
  kRealtimeMemoryLocked = 1u << 2,  // all memory, present and future, is locked
};

struct RealtimeOptions {
  int fifo_priority = 0;  // 1–99; 0: stay at normal priority
  bool lock_memory = false;
  size_t prefault_stack = 256 * 1024;  // of this thread, touched in advance [bytes]; 0: none
};

/// How to get refused rights.
inline constexpr const char* kMendRealtime =
    "run as root, or give the user 'rtprio 90' and 'memlock unlimited' in /etc/security/limits.d/ "
    "and log in again";

/// Rights granted and refused. A refusal is not fatal: the loop still runs and counts its late
/// ticks.
struct RealtimeReport {
  uint32_t bits = 0;     // RealtimeBit
  int fifo_errno = 0;    // why SCHED_FIFO was refused; 0: granted or not asked for
  int memory_errno = 0;  // why locked memory was refused; 0: granted or not asked for

  /// The first refusal; 0: everything requested was granted.
  int first_errno() const noexcept { return fifo_errno != 0 ? fifo_errno : memory_errno; }

  /// One line: what was refused, why, how to mend it; "real time: …" if everything was granted,
  /// "normal priority" if nothing was requested.
  std::string explain() const;
};

/// Makes the calling thread real time as far as permitted: timer slack 1 ns; SCHED_FIFO with
/// SCHED_RESET_ON_FORK (threads started later are normal) and RLIMIT_RTTIME of 2 s against a
/// runaway loop; memory locked and the stack touched. Memory is locked as a whole only with
/// CAP_IPC_LOCK or without a limit: under a finite RLIMIT_MEMLOCK a later mmap would fail, so
/// segments are locked singly and the report says EPERM. Call it once the attach thread runs.
RealtimeReport enter_realtime(const RealtimeOptions& options);

/// True if mlockall(MCL_FUTURE) is safe: CAP_IPC_LOCK, or no RLIMIT_MEMLOCK.
bool may_lock_all_memory() noexcept;

}  // namespace haptic
