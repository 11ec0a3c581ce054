// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/support/cyclictest.h"
#include "clients/lab/support/wake_lateness.h"
#include "clients/report/report.h"

namespace haptic {

/// One round of consecutive windows; a witness thread ran during the first two.
struct JitterRound {
  WitnessedRun sleep;
  CyclictestRun peer;
  WakeRun hybrid;
};

/// Why there are no figures of cyclictest to compare with; empty if every round has them.
std::string peer_problem_of(const std::vector<JitterRound>& rounds);

/// The output of `hapt bench jitter`. Goals apply only if SCHED_FIFO was granted, those against
/// cyclictest only if it gave figures. Needs at least one round.
void add_jitter_rows(const std::vector<JitterRound>& rounds, const Rows& all);

}  // namespace haptic
