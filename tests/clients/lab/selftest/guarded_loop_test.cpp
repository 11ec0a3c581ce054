// SPDX-License-Identifier: GPL-3.0-or-later
// The servo's own loop under rt_guard: a hundred thousand ticks here, a million in hapt selftest.
#include "clients/lab/selftest/guarded_loop.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "contact/bake/session.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"

namespace haptic {
namespace {

SessionConfig plane() {
  return load_config(test::from_source("configs/plane.toml"));
}

GuardedLoopResult run(const GuardedLoopOptions& options, const SessionConfig& config = plane()) {
  const BakedSession baked = bake_session(config);
  return run_guarded_loop(config, baked.shapes(), options);
}

void check_clean(const GuardedLoopResult& result) {
  CAPTURE(result.report.explain(), result.rights.explain());
  for (size_t kind = 0; kind < kViolations; ++kind) {
    const auto violation = static_cast<Violation>(kind);
    const bool is_fault =
        violation == Violation::kMinorFault || violation == Violation::kMajorFault;
    if (is_fault && (result.rights.bits & kRealtimeMemoryLocked) == 0) {
      WARN("SKIPPED: page faults, memory cannot be locked here");
      continue;
    }
    CAPTURE(name_of(violation));
    CHECK(result.report.caught[kind].count == 0);
  }
}

bool hooks_are_here() {
  if (guard_hooks_linked()) return true;
  WARN("SKIPPED: sanitizers interpose the same functions");
  return false;
}

}  // namespace

TEST_CASE("guarded loop: 100,000 ticks neither allocate, lock, fault nor ask the kernel", "[lab]") {
  if (!hooks_are_here()) return;
  const GuardedLoopResult result = run({.ticks = 100'000});
  CHECK(result.ticks == 101'000);
  CHECK(result.contact_ticks > 10'000);
  check_clean(result);
  CHECK(result.timed_ticks == 1000);
  CHECK(result.stray_sleeps() == 0);
  CHECK(result.lost_ticks == 0);
}

TEST_CASE("guarded loop: nor do the renderers of a tool with six degrees of freedom", "[lab]") {
  if (!hooks_are_here()) return;
  SessionConfig config = plane();
  config.renderer = GENERATE(Renderer::kVoxel, Renderer::kDirect6);
  config.proxy.solver = GENERATE(SoftSolver::kPenaltyDynamics, SoftSolver::kQuasiStatic);
  config.coupling.rotational_stiffness = 1;
  config.tool.primitive = primitive::Sphere{0.02, 2};
  // the second object is touched too, and harder
  config.n_objects = 2;
  config.objects[1] = config.objects[0];
  config.objects[1].X_WO.p = {1e-3, 1e-3, 1e-3};
  const GuardedLoopResult result = run({.ticks = 1200, .timed_ticks = 1, .warm_up = 500}, config);
  // a little more than one stroke of the hand; a late wake-up of a timed tick would shift it
  CHECK(result.contact_ticks > 300);
  check_clean(result);
}

TEST_CASE("guarded loop: a lock that is waited for in mid-run is caught and the run ends",
          "[lab]") {
  if (!hooks_are_here()) return;
  pthread_mutex_t held = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&held);
  int taken = 0;
  const GuardedLoopResult result =
      run({.ticks = 500, .timed_ticks = 20, .also_do = [&](uint64_t k) {
             if (k != 300) return;
             const int64_t until_ns = realtime_now_ns() + 10'000'000;
             const timespec until{until_ns / kNsPerSecond, until_ns % kNsPerSecond};
             taken = pthread_mutex_timedlock(&held, &until);
           }});
  pthread_mutex_unlock(&held);
  CAPTURE(result.report.explain());
  CHECK(taken == ETIMEDOUT);
  CHECK(result.report.of(Violation::kMutex).count == 1);
  CHECK(result.report.first_system_call == SYS_futex);
}

TEST_CASE("guarded loop: sleeps beside the one of each timed tick are told apart", "[lab]") {
  if (!hooks_are_here()) return;
  const GuardedLoopResult result =
      run({.ticks = 500, .timed_ticks = 20, .also_do = [&](uint64_t k) {
             if (k >= 300) sleep_until(now_ns() + 1'000'000);
           }});
  CHECK(result.report.violations() == 0);
  CHECK(result.timed_ticks == 20);
  CHECK(result.stray_sleeps() > 0);
}

TEST_CASE("guarded loop: one violation in mid-run is caught in the loop itself", "[lab]") {
  if (!hooks_are_here()) return;
  struct Plant {
    Violation kind;
    std::function<void()> body;
  };
  static std::mutex mutex;
  static std::shared_mutex rwlock;
  static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
  static void* memory = nullptr;
  const auto plant = GENERATE(values<Plant>({
      {Violation::kAllocate, [] { memory = std::malloc(64); }},
      {Violation::kFree, [] { std::free(std::exchange(memory, nullptr)); }},
      {Violation::kMutex, [] { const std::lock_guard lock(mutex); }},
      {Violation::kCondition, [] { pthread_cond_signal(&condition); }},
      {Violation::kRwlock, [] { const std::shared_lock lock(rwlock); }},
      {Violation::kSystemCall, [] { syscall(SYS_getppid); }},
      {Violation::kSystemCall, [] { usleep(50); }},
  }));
  if (memory == nullptr) memory = std::malloc(64);
  const GuardedLoopResult result =
      run({.ticks = 500, .timed_ticks = 20, .also_do = [&](uint64_t k) {
             if (k == 300) plant.body();
           }});
  CAPTURE(name_of(plant.kind), result.report.explain());
  CHECK(result.report.of(plant.kind).count == 1);
}

TEST_CASE("guarded loop: a page touched for the first time in mid-run is caught", "[lab]") {
  if (!hooks_are_here()) return;
  constexpr size_t kPage = 4096;
  void* page = mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  REQUIRE(page != MAP_FAILED);
  // locking maps every page: this one is discarded again, from outside the filter
  std::atomic<int> turn{0};
  std::thread taker([&] {
    while (turn.load() == 0) std::this_thread::yield();
    munlock(page, kPage);
    madvise(page, kPage, MADV_DONTNEED);
    turn.store(2);
  });
  const GuardedLoopResult result =
      run({.ticks = 500, .timed_ticks = 20, .also_do = [&](uint64_t k) {
             if (k != 300) return;
             turn.store(1);
             while (turn.load() != 2) {
             }
             *static_cast<volatile char*>(page) = 1;
           }});
  taker.join();
  munmap(page, kPage);
  CAPTURE(result.report.explain());
  CHECK(result.report.of(Violation::kMinorFault).count == 1);
}

}  // namespace haptic
