// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchCcdOptions {
  std::string queries;  // folder of ground truth; skipped if empty or absent
  size_t hand_scale = 20000;
  size_t motions = 200;  // of the tori
  int rounds = 5;
};

/// Continuous collision detection compared with its peers in the same run: vertex–face and
/// edge–edge on exact ground truth (false alarms and misses per file) and on queries at the scale
/// of a hand, against FCL and Redon's intervals; time of impact of two tori of 27 k and 40 k
/// triangles along motions of a hand at 1 kHz, checked by exact intersection at many earlier times.
std::vector<Row> bench_ccd(const BenchCcdOptions& options);

}  // namespace haptic
