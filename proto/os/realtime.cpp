// SPDX-License-Identifier: Apache-2.0
#include "proto/os/realtime.h"

#include <alloca.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace haptic {
namespace {

// kRunawayLimitUs [µs]: FIFO without a sleep, then SIGXCPU. kStackBytes: twice what
// enter_realtime() touches. The thread sanitizer is slower, and keeps more than a mebibyte of its
// own in each stack
#if defined(__SANITIZE_THREAD__)
constexpr rlim_t kRunawayLimitUs = 10'000'000;
constexpr size_t kStackBytes = size_t{4096} * 1024;
#else
constexpr rlim_t kRunawayLimitUs = 2'000'000;
constexpr size_t kStackBytes = size_t{512} * 1024;
#endif
constexpr size_t kPage = 4096;  // [bytes], the smallest of x86-64 and ARM64

bool has_ipc_lock() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {};
  if (syscall(SYS_capget, &header, data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

uint64_t memory_lock_limit() noexcept {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? ~uint64_t{0} : limit.rlim_cur;
}

int set_fifo(int priority) noexcept {
  sched_param param{};
  param.sched_priority = priority;
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param) != 0) return errno;
  rlimit limit{};
  getrlimit(RLIMIT_RTTIME, &limit);
  if (limit.rlim_cur > kRunawayLimitUs) {
    limit.rlim_cur = kRunawayLimitUs;
    setrlimit(RLIMIT_RTTIME, &limit);
  }
  return 0;
}

// noinline: the touched frame lies below all frames of the coming loop
[[gnu::noinline]] void touch_stack(size_t bytes) noexcept {
  auto* stack = static_cast<volatile char*>(alloca(bytes));
  for (size_t i = 0; i < bytes; i += kPage) stack[i] = 0;
}

}  // namespace

void sleep_until(int64_t deadline_ns) noexcept {
  const timespec t{deadline_ns / kNsPerSecond, deadline_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

uint64_t next_grid_point(int64_t start_ns, int64_t period, uint64_t last, int64_t now_ns) noexcept {
  const int64_t next_ns = start_ns + static_cast<int64_t>(last + 1) * period;
  if (now_ns <= next_ns) return last + 1;
  return static_cast<uint64_t>((now_ns - start_ns + period - 1) / period);
}

DeadlineClock::DeadlineClock(int64_t period, int64_t spin_ns) noexcept
    : period_(period), spin_ns_(std::min(spin_ns, period / 2)), start_ns_(now_ns() + period) {}

Tick DeadlineClock::wait() noexcept {
  // the unsigned wrap makes grid point 0 the successor of "none"
  const uint64_t index = next_grid_point(start_ns_, period_, next_ - 1, now_ns());
  skipped_ += index - next_;
  next_ = index + 1;
  const int64_t deadline_ns = start_ns_ + static_cast<int64_t>(index) * period_;
  sleep_until(deadline_ns - spin_ns_);
  int64_t woke_ns = now_ns();
  // hybrid: absorbs the lateness of the wake-up
  while (woke_ns < deadline_ns) woke_ns = now_ns();
  return {index, deadline_ns, woke_ns - deadline_ns, skipped_};
}

void use_small_thread_stacks() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, kStackBytes) == 0) {
    pthread_setattr_default_np(&attributes);
  }
  pthread_attr_destroy(&attributes);
}

bool may_lock_all_memory() noexcept {
  return has_ipc_lock() || memory_lock_limit() == ~uint64_t{0};
}

RealtimeReport enter_realtime(const RealtimeOptions& options) {
  RealtimeReport report;
  prctl(PR_SET_TIMERSLACK, 1UL);

  // memory first: page faults must not run at FIFO
  if (options.lock_memory) {
    report.bits |= kRealtimeWanted;
    if (!may_lock_all_memory()) {
      report.memory_errno = EPERM;
    } else if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
      report.memory_errno = errno;
    } else {
      report.bits |= kRealtimeMemoryLocked;
    }
  }
  if (options.prefault_stack > 0) touch_stack(options.prefault_stack);
  if (options.fifo_priority > 0) {
    report.bits |= kRealtimeWanted;
    report.fifo_errno = set_fifo(options.fifo_priority);
    if (report.fifo_errno == 0) report.bits |= kRealtimeFifo;
  }
  return report;
}

std::string RealtimeReport::explain() const {
  if ((bits & kRealtimeWanted) == 0) return "normal priority";
  std::string refused;
  if (fifo_errno != 0) refused = std::string("SCHED_FIFO (") + std::strerror(fifo_errno) + ")";
  if (memory_errno != 0) {
    refused += std::string(refused.empty() ? "" : " and ") + "locked memory (" +
               std::strerror(memory_errno) + ")";
  }
  if (!refused.empty()) return "not real-time here: refused " + refused + "; " + kMendRealtime;
  std::string text = "real time:";
  if ((bits & kRealtimeFifo) != 0) text += " SCHED_FIFO";
  if ((bits & kRealtimeMemoryLocked) != 0) text += " memory locked";
  return text;
}

}  // namespace haptic
