// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/os/realtime.h"
#include "proto/math/units.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <random>
#include <string>
#include <thread>

namespace haptic {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr uid_t kNobody = 65534;

/// Runs in a forked child, whose rights it may change, and returns its result.
template <typename Function>
std::string said_by_child(Function function) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) {
    const std::string text = function();
    const bool ok = write(ends[1], text.data(), text.size()) == ssize_t(text.size());
    _exit(ok ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, size_t(n));
  close(ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  CHECK(WIFEXITED(status));
  return text;
}

void drop_rights(rlim_t memory_limit) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_RTPRIO, &none);
  const rlimit memory{memory_limit, memory_limit};
  setrlimit(RLIMIT_MEMLOCK, &memory);
  if (geteuid() == 0 && setuid(kNobody) != 0) _exit(9);
}

}  // namespace

TEST_CASE("realtime: the next grid point is the first one not yet past") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 5000; ++i) {
    const int64_t period = int64_t(1 + random() % 50);
    const int64_t start = int64_t(random() % 1000);
    const uint64_t last = random() % 20;
    const int64_t now = int64_t(random() % 3000);
    // brute force: walk the grid
    uint64_t expected = last + 1;
    while (start + int64_t(expected) * period < now) ++expected;
    CAPTURE(period, start, last, now);
    CHECK(next_grid_point(start, period, last, now) == expected);
  }
}

TEST_CASE("realtime: the first grid point follows no other") {
  CHECK(next_grid_point(1000, 10, ~uint64_t{0}, 0) == 0);
  CHECK(next_grid_point(1000, 10, ~uint64_t{0}, 1000) == 0);
  CHECK(next_grid_point(1000, 10, ~uint64_t{0}, 1001) == 1);
}

TEST_CASE("realtime: a clock that is overslept skips and counts, it never catches up in a burst") {
  // asleep until the grid point, or spinning for the last of it
  DeadlineClock clock(2 * kMs, GENERATE(int64_t{0}, kHybridSpinNs));
  Tick before = clock.wait();
  const int64_t grid = before.deadline_ns - int64_t(before.index) * clock.period();
  uint64_t ticks = 1;
  for (int i = 0; i < 20; ++i) {
    // every fifth cycle takes longer than three periods
    if (i % 5 == 0) sleep_until(now_ns() + 7 * kMs);
    const int64_t asked_ns = now_ns();
    const Tick tick = clock.wait();
    ++ticks;
    CAPTURE(i, tick.index, tick.late_ns, tick.skipped);
    CHECK(now_ns() >= tick.deadline_ns);
    CHECK(tick.deadline_ns == grid + int64_t(tick.index) * clock.period());
    // never a deadline in the past: that would be a burst
    CHECK(tick.deadline_ns + clock.period() > asked_ns);
    CHECK(tick.late_ns >= 0);
    CHECK(tick.index + 1 == ticks + tick.skipped);
    if (i % 5 == 0) CHECK(tick.index >= before.index + 3);
    before = tick;
  }
}

TEST_CASE("realtime: a hybrid clock really spins, for at most half a period") {
  const int64_t period = GENERATE(1 * kMs, kMs / 8);
  const int64_t spin = std::min(kHybridSpinNs, period / 2);
  constexpr int kTicks = 50, kAttempts = 40;
  // the default timer slack of 50 us is most of the spin at 8 kHz; a real-time thread has none
  REQUIRE(prctl(PR_SET_TIMERSLACK, 1) == 0);
  // a late wake-up spins less: on a busy machine, one quiet interval is enough
  int64_t most_ns = 0;
  for (int k = 0; k < kAttempts && most_ns <= kTicks * spin / 4; ++k) {
    DeadlineClock clock(period, kHybridSpinNs);
    const int64_t used_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID);
    // what a hypervisor takes in mid-spin counts as time of the thread, and makes the tick late
    int64_t late_ns = 0;
    for (int i = 0; i < kTicks; ++i) late_ns += clock.wait().late_ns;
    const int64_t spent_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID) - used_ns;
    CHECK(spent_ns < kTicks * (spin + period / 4) + late_ns);
    most_ns = std::max(most_ns, spent_ns);
  }
  CAPTURE(period, most_ns);
  // a sleeping loop uses a few microseconds per tick
  CHECK(most_ns > kTicks * spin / 4);
}

TEST_CASE("realtime: nothing asked for is nothing refused") {
  const std::string said = said_by_child([] {
    const RealtimeReport report = enter_realtime({});
    return report.explain() + (report.bits == 0 && report.first_errno() == 0 ? " ok" : " bad");
  });
  CHECK(said == "normal priority ok");
}

TEST_CASE("realtime: without rights the report says what was refused and how to mend it") {
  const std::string said = said_by_child([] {
    drop_rights(64 * 1024);
    const RealtimeReport report = enter_realtime({.fifo_priority = 10, .lock_memory = true});
    if (report.bits != kRealtimeWanted || report.first_errno() != EPERM) return std::string("bad");
    // a large mapping still succeeds: no half-granted MCL_FUTURE
    void* large =
        mmap(nullptr, 9 << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (large == MAP_FAILED) return std::string("cannot map any more");
    return report.explain();
  });
  CHECK(said ==
        std::string("not real-time here: refused SCHED_FIFO (Operation not permitted) and locked "
                    "memory (Operation not permitted); ") +
            kMendRealtime);
}

TEST_CASE("realtime: with rights the thread is FIFO and what it forks is not") {
  const std::string said = said_by_child([] {
    const RealtimeReport report = enter_realtime({.fifo_priority = 10, .lock_memory = false});
    if (report.fifo_errno != 0) return std::string("refused");
    sched_param param{};
    sched_getparam(0, &param);
    const int policy = sched_getscheduler(0);
    const bool ok = (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO &&
                    (policy & SCHED_RESET_ON_FORK) != 0 && param.sched_priority == 10 &&
                    (report.bits & kRealtimeFifo) != 0;
    const pid_t pid = fork();
    if (pid == 0) _exit(sched_getscheduler(0));
    int status = 0;
    waitpid(pid, &status, 0);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != SCHED_OTHER) return std::string("inherited");
    return std::string(ok ? "granted" : "wrong");
  });
  if (said == "refused") {
    WARN("SKIPPED: SCHED_FIFO is not permitted here");
    return;
  }
  CHECK(said == "granted");
}

TEST_CASE("realtime: a thread's stack is small, and holds what a real-time thread touches of it") {
  // in a process of its own: it is the default of all threads from then on
  const pid_t child = fork();
  if (child == 0) {
    use_small_thread_stacks();
    const size_t most = size_t{kSanitized ? 4096 : 1024} * 1024;
    size_t bytes = 0;
    std::thread([&] {
      pthread_attr_t attributes;
      pthread_getattr_np(pthread_self(), &attributes);
      pthread_attr_getstacksize(&attributes, &bytes);
      enter_realtime({.fifo_priority = 0, .lock_memory = false});
    }).join();
    _exit(bytes > 256 * 1024 && bytes <= most ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
}

TEST_CASE("realtime: memory is locked as a whole only where that cannot fail later") {
  if (kSanitized) {
    WARN("SKIPPED: sanitizers turn mlockall into nothing");
    return;
  }
  const std::string said = said_by_child([] {
    if (!may_lock_all_memory()) return std::string("refused");
    const RealtimeReport report = enter_realtime({.fifo_priority = 0, .lock_memory = true});
    if (report.memory_errno != 0) return std::string("refused");
    void* page = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    unsigned char resident = 0;
    mincore(page, 4096, &resident);
    return std::string((resident & 1) != 0 ? "granted" : "not prefaulted");
  });
  if (said == "refused") {
    WARN("SKIPPED: mlockall is not permitted here");
    return;
  }
  CHECK(said == "granted");
}

}  // namespace haptic
