// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <thread>

#include "proto/os/realtime.h"
#include "proto/os/rt_guard.h"

namespace haptic::test {

/// Keeps what the compiler could otherwise see through and leave out.
template <typename T>
void use(T&& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

/// Runs `body` armed in a thread of its own and returns what was caught.
inline GuardReport guarded(const std::function<void()>& body) {
  GuardReport report;
  std::thread([&] {
    // as a servo begins: a stack that was never touched would fault in the handler of the signal
    enter_realtime({.fifo_priority = 0, .lock_memory = false});
    RtGuard guard;
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
inline bool hooks_are_here() {
  if (guard_hooks_linked()) return true;
  WARN("SKIPPED: sanitizers interpose the same functions");
  return false;
}

/// Nothing else is caught beside the planted one.
inline void check_only(const GuardReport& report, Violation kind, uint64_t count) {
  CAPTURE(name_of(kind), report.explain());
  CHECK(report.of(kind).count == count);
  CHECK(report.violations() == count);
}

}  // namespace haptic::test
