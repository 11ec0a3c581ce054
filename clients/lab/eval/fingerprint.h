// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/support/lockstep.h"
#include "clients/report/report.h"

namespace haptic {

struct FingerprintEval {
  std::vector<std::string> configs;  // session files
  double seconds = 4;                // of each
  LockstepOptions lockstep;
  std::string forces;  // folder of the forces of another build; none: only hashes
};

/// Hashes of the results of every tick, for each session file and each renderer that can play it. A
/// change of the code that is to change no behaviour must leave the hashes as they are. With a
/// folder, the wrenches of each session are kept there; if it holds them already, the largest
/// difference of a force is a row. A session whose hand is recorded plays its recording; one on a
/// device or without its meshes is left out, and a row says why. Throws ConfigError for a file that
/// cannot be read.
std::vector<Row> eval_fingerprint(const FingerprintEval& eval);

}  // namespace haptic
