// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchVoxelContactOptions {
  std::vector<std::string> pairs{"bolt", "free-bolt", "peg", "jaws"};
  int ticks = 10'000;   // of 1 kHz, for each pair
  double coarser = 1;   // times voxels and points, for a quick look
  int peer_asked = 60;  // times that a peer answers meanwhile
};

/// Whole contact steps of the detector `voxel` with the distance field, the tool's points in their
/// tree with temporal coherence, as a hand at 1 kHz asks for them: a bolt that is screwed and
/// pressed in its nut, one that wobbles in its gap and meets nothing, a peg in its hole, two jaws.
/// FCL in between, on the same poses. Then pressed deep, without a budget and with the one that
/// follows for 0.8 ms.
std::vector<Row> bench_voxel_contact(const BenchVoxelContactOptions& options);

}  // namespace haptic
