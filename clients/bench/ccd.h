// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchCcdOptions {
  std::string queries;  // folder of ground truth; empty or absent: left out
  size_t hand_scale = 20000;
  size_t motions = 200;  // of the tori
  int rounds = 5;
};

/// Continuous collision beside its peers, in the same run. Vertex–face and edge–edge on exact
/// ground truth (false alarms and misses by file) and on queries of a hand's scale, beside FCL and
/// Redon's intervals; the time of impact of two tori of 27 k and 40 k triangles along motions of a
/// hand at 1 kHz, each answer held against exact intersection at many times before it.
std::vector<Row> bench_ccd(const BenchCcdOptions& options);

}  // namespace haptic
