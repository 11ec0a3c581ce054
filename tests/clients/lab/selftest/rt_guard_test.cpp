// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/selftest/rt_guard.h"

#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>
#include <threads.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <shared_mutex>
#include <thread>

#include "proto/os/realtime.h"
#include "tests/support/guarded.h"

namespace haptic {
namespace {

using test::check_only;
using test::guarded;
using test::hooks_are_here;
using test::use;

/// One action that is forbidden in a real-time loop.
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
mtx_t c11_mutex;
pthread_spinlock_t spin;
sem_t semaphore;
void* memory = nullptr;  // passed to free, or allocated

const timespec kLongAgo{1, 0};

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
      {"memalign", Violation::kAllocate, 1, [] { memory = memalign(64, 64); }},
      {"valloc", Violation::kAllocate, 1, [] { memory = valloc(64); }},
      {"pvalloc", Violation::kAllocate, 1, [] { memory = pvalloc(64); }},
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
         static_cast<void>(pthread_mutex_trylock(&mutex));
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
      {"mtx_lock", Violation::kMutex, 1,
       [] {
         mtx_lock(&c11_mutex);
         mtx_unlock(&c11_mutex);
       }},
      {"pthread_spin_lock", Violation::kMutex, 1,
       [] {
         pthread_spin_lock(&spin);
         pthread_spin_unlock(&spin);
       }},
      {"sem_wait", Violation::kMutex, 1,
       [] {
         sem_wait(&semaphore);
         sem_post(&semaphore);
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
      {"std::shared_timed_mutex", Violation::kRwlock, 2,
       [] {
         static std::shared_timed_mutex m;
         if (m.try_lock_for(std::chrono::seconds(1))) m.unlock();
         if (m.try_lock_shared_for(std::chrono::seconds(1))) m.unlock_shared();
       }},
  }));
  CAPTURE(plant.what);
  mtx_init(&c11_mutex, mtx_plain);
  pthread_spin_init(&spin, PTHREAD_PROCESS_PRIVATE);
  sem_init(&semaphore, 0, 1);
  if (memory == nullptr) memory = std::malloc(64);
  GuardReport report = guarded(plant.body);
  // code that runs for the first time may still have to be mapped
  report.of(Violation::kMinorFault).count = 0;
  check_only(report, plant.kind, plant.count);
  if (plant.count > 0) CHECK(report.of(plant.kind).depth > 1);
  // unguarded it works as usual
  std::free(memory);
  memory = nullptr;
}

TEST_CASE("rt_guard: under the hooks an alignment that makes no sense is refused as ever") {
  if (!hooks_are_here()) return;
  void* nothing = nullptr;
  // indirect, or the compiler would refuse it first
  for (const size_t alignment : {size_t{0}, size_t{2}, size_t{24}, size_t{48}}) {
    CAPTURE(alignment);
    CHECK(posix_memalign(&nothing, alignment, 64) == EINVAL);
  }
  CHECK(posix_memalign(&nothing, 4096, 64) == 0);
  std::free(nothing);
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

}  // namespace haptic
