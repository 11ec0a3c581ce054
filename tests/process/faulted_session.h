// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "clients/faults.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kFaultsSanitized = true;
#else
inline constexpr bool kFaultsSanitized = false;
#endif

/// A session on an emulated device whose hand presses, without real-time rights, and faults in it.
/// Every force is read from the emulator's log.
struct FaultedSession {
  static constexpr int kAttempts = 3;  // what is broken breaks each time, a busy machine does not

  TemporaryFolder folder;
  TortureSession session;
  FaultInjector injector{session, 1};
  // where no attempt that counts has replaced them
  uint64_t servo_generation = 1, contact_generation = 1;

  explicit FaultedSession(bool recorded = false)
      : session({folder.path(), recorded ? folder.path() + "/run" : "", false}) {}

  /// Does a fault and fails the test where the judge finds a violation.
  FaultOutcome inject(FaultKind kind) {
    FaultOutcome outcome;
    for (int i = 0; i < kAttempts; ++i) {
      if (i > 0) {
        servo_generation = session.servo().generation;
        contact_generation = session.contact().generation;
      }
      outcome = injector.inject(kind);
      forgive_slowness(outcome);
      if (outcome.violations.empty()) break;
    }
    for (const std::string& violation : outcome.violations) {
      FAIL_CHECK(info_of(kind).name << ": " << violation);
    }
    return outcome;
  }

  /// Whether the hand feels more than half of what the block gives at rest, in a while: a busy
  /// machine may have let the force fade a moment ago.
  bool is_pressing() {
    return session.wait_until(
        [this] { return !session.records().empty() && session.records().back().force_B.z > 1; },
        kPatienceNs);
  }

 private:
  /// A sanitizer makes the start of a process too slow for a stated time, and 64 clients so heavy
  /// that a servo without real-time rights misses ticks. Force limits, zeros and rises still count.
  static void forgive_slowness(FaultOutcome& outcome) {
    if (!kFaultsSanitized) return;
    const bool starves = outcome.kind == FaultKind::kManyClients;
    std::erase_if(outcome.violations, [starves](const std::string& violation) {
      const bool changed = violation.find(name_of(ForceBreach::kChanged)) != violation.npos;
      return violation.find("whole again after") == 0 || (starves && changed);
    });
  }
};

}  // namespace haptic::test
