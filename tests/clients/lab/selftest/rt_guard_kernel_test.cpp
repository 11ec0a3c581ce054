// SPDX-License-Identifier: GPL-3.0-or-later
// Violations that the guard learns from the kernel: system calls, sleeps, faults, switches.
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "clients/lab/selftest/rt_guard.h"
#include "proto/os/realtime.h"
#include "tests/support/guarded.h"

namespace haptic {
namespace {

using test::check_only;
using test::guarded;
using test::hooks_are_here;
using test::use;

constexpr size_t kPage = 4096;

timespec in_ten_milliseconds() {
  const int64_t t_ns = realtime_now_ns() + 10'000'000;
  return {t_ns / kNsPerSecond, t_ns % kNsPerSecond};
}

/// A child's standard error, and how it ends.
struct Ended {
  std::string said;
  int signal = 0;  // 0: not ended by a signal
};

Ended run_in_child(const std::function<void()>& body) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) {
    dup2(ends[1], STDERR_FILENO);
    // Catch2 would report its own failure
    signal(SIGABRT, SIG_DFL);
    signal(SIGSEGV, SIG_DFL);
    body();
    _exit(0);
  }
  close(ends[1]);
  Ended ended;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
    ended.said.append(buffer, size_t(n));
  }
  close(ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  if (WIFSIGNALED(status)) ended.signal = WTERMSIG(status);
  return ended;
}

}  // namespace

TEST_CASE("rt_guard: an unlisted system call is refused, counted and named") {
  if (!hooks_are_here()) return;
  long result = 0;
  int error = 0;
  const GuardReport report = guarded([&] {
    for (int i = 0; i < 3; ++i) result = syscall(SYS_getppid);
    error = errno;
  });
  check_only(report, Violation::kSystemCall, 3);
  CHECK(report.first_system_call == SYS_getppid);
  CHECK(result == -1);
  CHECK(error == ENOSYS);
  CHECK_THAT(report.explain(), Catch::StartsWith("system call × 3 (getppid): "));
}

TEST_CASE("rt_guard: the filter holds for its own thread only") {
  if (!hooks_are_here()) return;
  guarded([] {});
  CHECK(syscall(SYS_getppid) == getppid());
}

TEST_CASE("rt_guard: a wait for a lock is caught, named, and still waits") {
  if (!hooks_are_here()) return;
  struct Wait {
    const char* what;
    Violation kind;
    std::function<int()> body;
  };
  static pthread_mutex_t held = PTHREAD_MUTEX_INITIALIZER;
  static pthread_mutex_t own = PTHREAD_MUTEX_INITIALIZER;
  static pthread_cond_t never = PTHREAD_COND_INITIALIZER;
  static pthread_rwlock_t written = PTHREAD_RWLOCK_INITIALIZER;
  const auto wait = GENERATE(values<Wait>({
      {"mutex", Violation::kMutex,
       [] {
         const timespec until = in_ten_milliseconds();
         return pthread_mutex_timedlock(&held, &until);
       }},
      {"condition", Violation::kCondition,
       [] {
         const timespec until = in_ten_milliseconds();
         pthread_mutex_lock(&own);
         const int result = pthread_cond_timedwait(&never, &own, &until);
         pthread_mutex_unlock(&own);
         return result;
       }},
      {"rwlock", Violation::kRwlock,
       [] {
         const timespec until = in_ten_milliseconds();
         return pthread_rwlock_timedrdlock(&written, &until);
       }},
  }));
  CAPTURE(wait.what);
  // locked by this thread, so the guarded one has to wait
  pthread_mutex_lock(&held);
  pthread_rwlock_wrlock(&written);
  int result = 0;
  const GuardReport report = guarded([&] { result = wait.body(); });
  pthread_rwlock_unlock(&written);
  pthread_mutex_unlock(&held);
  CAPTURE(report.explain());
  CHECK(result == ETIMEDOUT);
  CHECK(report.of(wait.kind).count == 1);
  CHECK(report.of(Violation::kSystemCall).count >= 1);
  CHECK(report.first_system_call == SYS_futex);
}

TEST_CASE("rt_guard: a lock that another thread holds is given over, guarded or not") {
  if (!hooks_are_here()) return;
  static std::once_flag once;
  std::atomic<bool> inside{false}, waits{false};
  std::thread other([&] {
    std::call_once(once, [&] {
      inside = true;
      while (!waits) std::this_thread::yield();
    });
  });
  const GuardReport report = guarded([&] {
    while (!inside) {
    }
    waits = true;
    std::call_once(once, [] {});
  });
  other.join();
  CAPTURE(report.explain());
  // whether it had to wait is up to the scheduler; it must only return
  if (report.of(Violation::kSystemCall).count > 0) CHECK(report.first_system_call == SYS_futex);
}

TEST_CASE("rt_guard: a sleep that is not until a deadline, and other clocks, are refused") {
  if (!hooks_are_here()) return;
  struct Call {
    const char* what;
    std::function<void()> body;
    long number;
  };
  const auto call = GENERATE(values<Call>({
      {"usleep", [] { usleep(50); }, SYS_clock_nanosleep},
      {"sleep_for", [] { std::this_thread::sleep_for(std::chrono::microseconds(50)); },
       SYS_clock_nanosleep},
      {"relative, on the deadlines' clock",
       [] {
         const timespec t{0, 50'000};
         clock_nanosleep(CLOCK_MONOTONIC, 0, &t, nullptr);
       },
       SYS_clock_nanosleep},
      {"until an instant of another clock",
       [] {
         const timespec t{0, 50'000};
         clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &t, nullptr);
       },
       SYS_clock_nanosleep},
      {"getrusage",
       [] {
         rusage usage{};
         getrusage(RUSAGE_SELF, &usage);
       },
       SYS_getrusage},
      {"clock of the thread", [] { use(read_clock_ns(CLOCK_THREAD_CPUTIME_ID)); },
       SYS_clock_gettime},
  }));
  CAPTURE(call.what);
  const GuardReport report = guarded(call.body);
  CAPTURE(report.explain());
  CHECK(report.of(Violation::kSystemCall).count == 1);
  CHECK(report.first_system_call == call.number);
}

TEST_CASE("rt_guard: a sleep more than the owner meant shows in the voluntary switches") {
  if (!hooks_are_here()) return;
  constexpr int kSleeps = 20;
  const GuardReport report = guarded([] {
    for (int i = 0; i < kSleeps; ++i) sleep_until(now_ns() + 1'000'000);
  });
  CHECK(report.violations() == 0);
  CHECK(report.voluntary_switches > 0);
  CHECK(report.voluntary_switches <= kSleeps);
}

TEST_CASE("rt_guard: a thread of higher priority on the same core is an involuntary switch") {
  if (!hooks_are_here()) return;
  cpu_set_t before, one;
  sched_getaffinity(0, sizeof before, &before);
  CPU_ZERO(&one);
  CPU_SET(static_cast<size_t>(sched_getcpu()), &one);
  // threads started from here stay on this core
  REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);
  std::atomic<bool> gave_up{false};
  std::atomic<int> turns{0};
  std::atomic<uint64_t> laps{0};  // of the guarded thread
  std::thread higher([&] {
    gave_up = enter_realtime({.fifo_priority = 1, .lock_memory = false}).fifo_errno != 0;
    uint64_t seen = 0;
    while (!gave_up && turns < 3) {
      sleep_until(now_ns() + 1'000'000);
      // the guarded thread has run since the last turn, so it was preempted
      if (laps != seen) ++turns;
      seen = laps;
    }
  });
  // it never sleeps: the other can only run by preempting it
  const GuardReport report = guarded([&] {
    while (turns < 3 && !gave_up) ++laps;
  });
  higher.join();
  sched_setaffinity(0, sizeof before, &before);
  if (gave_up) {
    WARN("SKIPPED: SCHED_FIFO is refused here, no thread is of higher priority");
    return;
  }
  CAPTURE(report.explain());
  CHECK(report.involuntary_switches >= 3);
}

TEST_CASE("rt_guard: until it is armed for the first time the thread may ask for anything") {
  if (!hooks_are_here()) return;
  long in_warm_up = 0, later = 0;
  GuardReport report;
  std::thread([&] {
    RtGuard guard;
    in_warm_up = syscall(SYS_getppid);
    guard.arm();
    guard.disarm();
    // refused from now on, which must be noticed
    later = syscall(SYS_getppid);
    report = guard.report();
  }).join();
  CHECK(in_warm_up == getppid());
  CHECK(later == -1);
  check_only(report, Violation::kSystemCall, 1);
}

TEST_CASE("rt_guard: the device's node may be read and written, no other descriptor") {
  if (!hooks_are_here()) return;
  int node[2], other[2];
  REQUIRE(pipe2(node, O_NONBLOCK) == 0);
  REQUIRE(pipe2(other, O_NONBLOCK) == 0);
  char byte = 'x';
  ssize_t n_node = 0, n_other = 0;
  GuardReport report;
  std::thread([&] {
    RtGuard guard({.device_node = node[1]});
    guard.arm();
    n_node = write(node[1], &byte, 1);
    n_other = write(other[1], &byte, 1);
    guard.disarm();
    report = guard.report();
  }).join();
  CHECK(n_node == 1);
  CHECK(n_other == -1);
  check_only(report, Violation::kSystemCall, 1);
  CHECK(report.first_system_call == SYS_write);
  for (const int fd : {node[0], node[1], other[0], other[1]}) close(fd);
}

TEST_CASE("rt_guard: a loop that aborts says so and where, though the filter refuses to write") {
  if (!hooks_are_here()) return;
  const Ended ended = run_in_child([] {
    RtGuard guard;
    guard.arm();
    std::abort();
  });
  CHECK(ended.signal == SIGABRT);
  CHECK_THAT(ended.said, Catch::StartsWith("rt_guard: the guarded loop did: abort\n"));
  CHECK_THAT(ended.said, Catch::Contains("test_rt_guard"));
}

TEST_CASE("rt_guard: strict, it says what the loop did and aborts") {
  if (!hooks_are_here()) return;
  const Ended ended = run_in_child([] {
    RtGuard guard({.abort_at_once = true});
    guard.arm();
    use(std::malloc(64));
  });  // NOLINT(clang-analyzer-unix.Malloc): it aborts
  CHECK(ended.signal == SIGABRT);
  CHECK_THAT(ended.said, Catch::StartsWith("rt_guard: the guarded loop did: allocation\n"));
}

TEST_CASE("rt_guard: strict, writing is no less forbidden") {
  if (!hooks_are_here()) return;
  const Ended ended = run_in_child([] {
    RtGuard guard({.abort_at_once = true});
    guard.arm();
    use(write(STDERR_FILENO, "all is well", 11));
  });
  CHECK(ended.signal == SIGABRT);
  CHECK_THAT(ended.said, Catch::StartsWith("rt_guard: the guarded loop did: system call\n"));
}

TEST_CASE("rt_guard: a first touch of a page is a fault that is counted") {
  if (!hooks_are_here()) return;
  constexpr size_t kPages = 7;
  void* fresh =
      mmap(nullptr, kPages * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  REQUIRE(fresh != MAP_FAILED);
  madvise(fresh, kPages * kPage, MADV_NOHUGEPAGE);
  auto* bytes = static_cast<volatile char*>(fresh);
  const GuardReport report = guarded([&] {
    for (size_t i = 0; i < kPages; ++i) bytes[i * kPage] = 1;
  });
  check_only(report, Violation::kMinorFault, kPages);
  CHECK(guarded([&] { bytes[0] = 2; }).violations() == 0);
  munmap(fresh, kPages * kPage);
}

TEST_CASE("rt_guard: a page that must be read from a file is a major fault") {
  if (!hooks_are_here()) return;
  char path[] = "/var/tmp/rt_guard_XXXXXX";
  const int fd = mkstemp(path);
  REQUIRE(fd >= 0);
  unlink(path);
  const std::vector<char> content(kPage, 'x');
  REQUIRE(write(fd, content.data(), content.size()) == ssize_t(content.size()));
  fsync(fd);
  posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
  void* mapped = mmap(nullptr, kPage, PROT_READ, MAP_PRIVATE, fd, 0);
  REQUIRE(mapped != MAP_FAILED);
  unsigned char resident = 1;
  mincore(mapped, kPage, &resident);
  if ((resident & 1) != 0) {
    WARN("SKIPPED: /var/tmp keeps its files in memory, no page has to be read");
    return;
  }
  const GuardReport report = guarded([&] {
    const char first = *static_cast<volatile char*>(mapped);
    use(first);
  });
  munmap(mapped, kPage);
  close(fd);
  check_only(report, Violation::kMajorFault, 1);
}

}  // namespace haptic
