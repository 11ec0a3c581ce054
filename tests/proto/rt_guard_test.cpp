// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/rt_guard.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <thread>
#include <vector>

#include "proto/realtime.h"

namespace haptic {
namespace {

constexpr size_t kPage = 4096;

/// Keeps what the compiler could otherwise see through and leave out.
template <typename T>
void use(T&& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

/// Runs `body` armed in a thread of its own and returns what was caught.
GuardReport guarded(const std::function<void()>& body, bool filter = true) {
  GuardReport report;
  std::thread([&] {
    RtGuard guard({.filter_system_calls = filter});
    guard.arm();
    guard.disarm();
    guard.arm();
    body();
    guard.disarm();
    report = guard.report();
  }).join();
  return report;
}

/// Says loudly that interposition is not to be had, where it is not.
bool hooks_are_here() {
  if (guard_hooks_linked()) return true;
  WARN("SKIPPED: sanitizers interpose the same functions");
  return false;
}

/// One thing a real-time loop must not do.
struct Plant {
  const char* what;
  Violation kind;
  uint64_t count;
  std::function<void()> body;
};

void* const kNothing = nullptr;
pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
pthread_rwlock_t rwlock = PTHREAD_RWLOCK_INITIALIZER;
void* memory = nullptr;  // given to free, or taken

const timespec kLongAgo{1, 0};

/// Nothing else is caught beside the planted one.
void check_only(const GuardReport& report, Violation kind, uint64_t count) {
  CAPTURE(name_of(kind), report.explain());
  CHECK(report.of(kind).count == count);
  CHECK(report.violations() == count);
}

}  // namespace

TEST_CASE("rt_guard: what the servo's loop does is no violation") {
  if (!hooks_are_here()) return;
  const GuardReport report = guarded([] {
    DeadlineClock clock(kNsPerSecond / 4000);
    for (int i = 0; i < 200; ++i) {
      clock.wait();
      use(realtime_now_ns());
    }
  });
  CAPTURE(report.explain());
  CHECK(report.violations() == 0);
  CHECK(report.explain().empty());
  CHECK(report.voluntary_switches > 0);
}

TEST_CASE("rt_guard: each planted call of libc is caught once, by its kind") {
  if (!hooks_are_here()) return;
  const auto plant = GENERATE(values<Plant>({
      {"malloc", Violation::kAllocate, 1, [] { memory = std::malloc(64); }},
      {"calloc", Violation::kAllocate, 1, [] { memory = std::calloc(4, 16); }},
      {"realloc", Violation::kAllocate, 1, [] { memory = std::realloc(memory, 128); }},
      {"posix_memalign", Violation::kAllocate, 1,
       [] {
         if (posix_memalign(&memory, 64, 64) != 0) std::abort();
       }},
      {"aligned_alloc", Violation::kAllocate, 1, [] { memory = std::aligned_alloc(64, 64); }},
      {"operator new", Violation::kAllocate, 1, [] { memory = ::operator new(64); }},
      {"operator new, aligned", Violation::kAllocate, 1,
       [] { memory = ::operator new (64, std::align_val_t{128}); }},
      {"free", Violation::kFree, 1,
       [] {
         std::free(memory);
         memory = nullptr;
       }},
      {"operator delete", Violation::kFree, 1,
       [] {
         ::operator delete(memory);
         memory = nullptr;
       }},
      {"free of nothing", Violation::kFree, 0, [] { std::free(kNothing); }},
      {"pthread_mutex_lock", Violation::kMutex, 1,
       [] {
         pthread_mutex_lock(&mutex);
         pthread_mutex_unlock(&mutex);
       }},
      {"pthread_mutex_trylock", Violation::kMutex, 1,
       [] {
         pthread_mutex_trylock(&mutex);
         pthread_mutex_unlock(&mutex);
       }},
      {"pthread_mutex_timedlock", Violation::kMutex, 1,
       [] {
         pthread_mutex_timedlock(&mutex, &kLongAgo);
         pthread_mutex_unlock(&mutex);
       }},
      {"std::mutex", Violation::kMutex, 1,
       [] {
         static std::mutex m;
         const std::lock_guard lock(m);
       }},
      {"pthread_cond_signal", Violation::kCondition, 1, [] { pthread_cond_signal(&condition); }},
      {"pthread_cond_broadcast", Violation::kCondition, 1,
       [] { pthread_cond_broadcast(&condition); }},
      {"pthread_rwlock_rdlock", Violation::kRwlock, 1,
       [] {
         pthread_rwlock_rdlock(&rwlock);
         pthread_rwlock_unlock(&rwlock);
       }},
      {"std::shared_mutex", Violation::kRwlock, 1,
       [] {
         static std::shared_mutex m;
         const std::unique_lock lock(m);
       }},
  }));
  CAPTURE(plant.what);
  if (memory == nullptr) memory = std::malloc(64);
  GuardReport report = guarded(plant.body);
  // code that runs for the first time may still have to be mapped
  report.of(Violation::kMinorFault).count = 0;
  check_only(report, plant.kind, plant.count);
  if (plant.count > 0) CHECK(report.of(plant.kind).depth > 1);
  // unguarded it works as ever
  std::free(memory);
  memory = nullptr;
}

TEST_CASE("rt_guard: a wait on a condition variable is caught, and still waits") {
  if (!hooks_are_here()) return;
  // without the filter: the wait is a futex, which the filter would refuse
  const GuardReport report = guarded(
      [] {
        timespec until{};
        clock_gettime(CLOCK_REALTIME, &until);
        pthread_mutex_lock(&mutex);
        const int result = pthread_cond_timedwait(&condition, &mutex, &until);
        pthread_mutex_unlock(&mutex);
        if (result != ETIMEDOUT) std::abort();
      },
      false);
  CAPTURE(report.explain());
  CHECK(report.of(Violation::kCondition).count == 1);
  CHECK(report.of(Violation::kMutex).count == 1);
}

TEST_CASE("rt_guard: threads that wait for each other work as before under the hooks") {
  std::mutex m;
  std::condition_variable changed;
  int turn = 0;
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) {
      std::unique_lock lock(m);
      changed.wait(lock, [&] { return turn % 2 == 1; });
      ++turn;
      changed.notify_one();
    }
  });
  for (int i = 0; i < 1000; ++i) {
    std::unique_lock lock(m);
    changed.wait(lock, [&] { return turn % 2 == 0; });
    ++turn;
    changed.notify_one();
  }
  other.join();
  CHECK(turn == 2000);
}

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

TEST_CASE("rt_guard: what happens before arming and after disarming is nobody's business") {
  if (!hooks_are_here()) return;
  GuardReport report;
  std::thread([&] {
    RtGuard guard;
    std::free(std::malloc(64));
    guard.arm();
    guard.disarm();
    std::free(std::malloc(64));
    pthread_mutex_lock(&mutex);
    pthread_mutex_unlock(&mutex);
    report = guard.report();
  }).join();
  CHECK(report.violations() == 0);
}

TEST_CASE("rt_guard: strict, it says what the loop did and aborts") {
  if (!hooks_are_here()) return;
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) {
    dup2(ends[1], STDERR_FILENO);
    RtGuard guard({.abort_at_once = true});
    // Catch2 would report a failure of its own
    signal(SIGABRT, SIG_DFL);
    guard.arm();
    use(std::malloc(64));
    _exit(0);
  }
  close(ends[1]);
  std::string said;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) said.append(buffer, size_t(n));
  close(ends[0]);
  int status = 0;
  waitpid(pid, &status, 0);
  CHECK(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == SIGABRT);
  CHECK_THAT(said, Catch::StartsWith("rt_guard: the armed loop did: allocation\n"));
}

}  // namespace haptic
