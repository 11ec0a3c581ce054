// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchVoxelContactOptions {
  std::vector<std::string> pairs{"bolt", "free-bolt", "peg", "jaws"};
  int ticks = 10'000;   // per pair
  double coarser = 1;   // scale of voxels and point spacing, for a quick look
  int peer_asked = 60;  // number of queries to the peer
};

/// Whole contact steps of the detector `voxel` with the distance field and temporal coherence along
/// a hand's motion at 1 kHz: a bolt screwed and pressed in its nut, one that wobbles in its gap
/// without contact, a peg in its hole, two jaws. FCL on the same poses in between. Then pressed in
/// deep, without a budget and with one for 0.8 ms.
void bench_voxel_contact(const BenchVoxelContactOptions& options, const Rows& all);

}  // namespace haptic
