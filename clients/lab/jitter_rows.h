// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/cyclictest.h"
#include "clients/lab/wake_lateness.h"
#include "clients/report/report.h"

namespace haptic {

/// One round of windows, one after the other; a witness ran beside the first two.
struct JitterRound {
  WitnessedRun sleep;
  CyclictestRun peer;
  WakeRun hybrid;
};

/// Why there are no figures of cyclictest to compare with; empty: there are, in every round.
std::string peer_problem_of(const std::vector<JitterRound>& rounds);

/// What `hapt bench jitter` prints. Goals are judged only where SCHED_FIFO was granted, those
/// beside cyclictest only where it gave figures. At least one round.
Rows make_jitter_rows(const std::vector<JitterRound>& rounds);

}  // namespace haptic
