// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "clients/bench/voxel_contact.h"

namespace haptic {

struct BenchVoxelOptions {
  std::vector<uint32_t> sides{256, 1024};                    // voxels along the object
  std::vector<uint32_t> points{10'000, 100'000, 1'000'000};  // of the shell
  uint32_t coarse = 16, fine = 235;                          // bumpy spheres of 20 f² triangles
  uint32_t memory_side = 1024;  // voxels along the bunny, for the memory of its maps; 0: skipped
  int rounds = 15;
  BenchVoxelContactOptions contact;
};

/// Points of a shell tested per microsecond of CPU time on one core in maps of a bumpy sphere:
/// Morton order and shuffled, scalar, SIMD, and in the 512-tree; compared with a ceiling that does
/// the same arithmetic and loads only. Then for an object with many more triangles, and the share
/// of points of a passing tool that temporal coherence leaves to be tested.
std::vector<Row> bench_voxel(const BenchVoxelOptions& options);

}  // namespace haptic
