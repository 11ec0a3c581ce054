// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/mman.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "clients/lab/selftest/rt_guard.h"
#include "proto/os/realtime.h"

namespace haptic::test {

/// Hides a value from the optimiser.
template <typename T>
void use(T&& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

/// Maps the code of the program and its libraries, so that a first call is no page fault. The
/// kernel maps the neighbours of a touched page, but not those that are locked at that moment.
inline void touch_code() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    unsigned long from = 0, to = 0;
    char access[5] = "";
    if (std::sscanf(line.c_str(), "%lx-%lx %4s", &from, &to, access) != 3) continue;
    if (access[0] != 'r' || access[2] != 'x') continue;
    madvise(reinterpret_cast<void*>(from), to - from,
            MADV_POPULATE_READ);  // older kernels: nothing
  }
}

/// Runs `body` guarded in its own thread and returns the violations.
inline GuardReport guarded(const std::function<void()>& body) {
  GuardReport report;
  touch_code();
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
