// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <thread>

#include "proto/os/realtime.h"
#include "proto/os/rt_guard.h"

namespace haptic::test {

/// Hides a value from the optimiser.
template <typename T>
void use(T&& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

/// Runs `body` guarded in its own thread and returns the violations.
inline GuardReport guarded(const std::function<void()>& body) {
  GuardReport report;
  std::thread([&] {
    // like the servo at its start: an untouched stack would fault in the signal handler
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

/// Prints a warning if interposition is not available.
inline bool hooks_are_here() {
  if (guard_hooks_linked()) return true;
  WARN("SKIPPED: sanitizers interpose the same functions");
  return false;
}

/// Nothing is caught except the planted violation.
inline void check_only(const GuardReport& report, Violation kind, uint64_t count) {
  CAPTURE(name_of(kind), report.explain());
  CHECK(report.of(kind).count == count);
  CHECK(report.violations() == count);
}

}  // namespace haptic::test
