// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <string>

#include "clients/lab/torture/faults.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

/// A session on an emulated device whose hand presses, and faults in it; with real-time priorities
/// if granted, so that other programs do not decide the result. Every force is read from the
/// emulator's log.
struct FaultedSession {
  static constexpr int kAttempts = 3;  // a defect shows each time, a busy machine does not

  TemporaryFolder folder;
  TortureSession session;
  FaultInjector injector{session, 1};

  explicit FaultedSession(bool recorded = false, bool six = false)
      : session({folder.path(), recorded ? folder.path() + "/run" : "", true, six}) {}

  /// Injects a fault and fails the test if there is a violation, or if servo or contact was
  /// replaced although the fault was not theirs. Each attempt begins with `first`.
  FaultOutcome inject(FaultKind kind, const std::function<void()>& first = {}) {
    FaultOutcome outcome;
    for (int i = 0; i < kAttempts; ++i) {
      // the documented recovery time does not hold for a second death within ten seconds
      while (i > 0 && now_ns() < injector.ready_ns(kind)) session.pause(kNsPerSecond / 10);
      const uint64_t servo = session.servo().generation, contact = session.contact().generation;
      if (first) first();
      outcome = injector.inject(kind);
      outcome.violations.insert(outcome.violations.end(), outcome.before.begin(),
                                outcome.before.end());
      forgive_slowness(outcome);
      if (session.servo().generation != servo && !may_replace_servo(kind)) {
        outcome.violations.push_back("the servo was replaced");
      }
      if (session.contact().generation != contact && !may_replace_contact(kind)) {
        outcome.violations.push_back("contact was replaced");
      }
      if (outcome.violations.empty()) return outcome;
    }
    for (const std::string& violation : outcome.violations) {
      FAIL_CHECK(info_of(kind).name << ": " << violation);
    }
    FAIL_CHECK("its programs said:\n" << std::ifstream(folder.path() + "/said").rdbuf());
    return outcome;
  }

  /// Waits until the hand feels more than half of the block's force at rest: on a busy machine the
  /// force may just have faded.
  bool is_pressing() {
    return session.wait_until(
        [this] { return !session.records().empty() && session.records().back().force_B.z > 1; },
        kPatienceNs);
  }

 private:
  static bool is_one_of(FaultKind kind, std::initializer_list<FaultKind> kinds) {
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
  }
  /// Those of the machine count too: with 64 clients this process may wait for a core.
  static bool may_replace(FaultKind kind) {
    return is_one_of(kind, {FaultKind::kHapticdKill, FaultKind::kHapticdServoKill,
                            FaultKind::kMemory, FaultKind::kBusy});
  }
  static bool may_replace_servo(FaultKind kind) {
    return may_replace(kind) || is_one_of(kind, {FaultKind::kServoKill, FaultKind::kServoStop});
  }
  static bool may_replace_contact(FaultKind kind) {
    return may_replace(kind) || is_one_of(kind, {FaultKind::kContactKill, FaultKind::kContactHang,
                                                 FaultKind::kManyClients});
  }

  /// With a sanitizer, processes start too slowly for documented times, and 64 clients are such a
  /// load that a servo without real-time rights misses ticks. Force limits, zeros and rises still
  /// count.
  static void forgive_slowness(FaultOutcome& outcome) {
    if (kSlowdown == 1) return;
    const bool starves = outcome.kind == FaultKind::kManyClients;
    std::erase_if(outcome.violations, [starves](const std::string& violation) {
      const bool changed = violation.find(name_of(ForceBreach::kChanged)) != violation.npos;
      return violation.starts_with("whole again after") ||
             violation.starts_with("replaced after") || (starves && changed);
    });
  }
};

}  // namespace haptic::test
