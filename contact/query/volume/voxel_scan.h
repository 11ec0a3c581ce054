// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/volume/shell_in_voxels.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

/// Implementation of the look-up; the results are bit-identical. kLanes needs room for 64 more
/// hits, else falls back to kScalar.
enum class ScanPath { kScalar, kLanes };

/// kLanes if the processor has AVX2.
ScanPath fastest_scan();

/// Looks up the voxels of the points first … first + count − 1, in order, and appends those that
/// are not free to `hits` from index `n` on, as long as there is room. Returns the new number of
/// hits. Points are rounded to float in voxels, an error of at most 1e-4 voxel in a map of 1024
/// voxels. Points outside the map are free. `hits` beyond the new number is undefined.
size_t scan_voxels(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                   uint32_t first, uint32_t count, ScanPath path, std::span<VoxelHit> hits,
                   size_t n);

}  // namespace haptic
