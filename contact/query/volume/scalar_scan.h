// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/query/volume/shell_in_voxels.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

/// Looks up one point after the other, in any map that has at(voxel). The lanes of voxel_scan.cpp
/// must agree with it.
namespace haptic {

using Limits = std::array<float, 3>;  // voxels along each axis

inline Limits limits_of(const VoxelIndex& cells, int side) {
  const auto limit = [&](size_t k) { return static_cast<float>(cells[k] * side); };
  return {limit(0), limit(1), limit(2)};
}

/// One coordinate, in the order of operations of the lanes.
inline float coordinate(const Pointshell& shell, const ShellInVoxels& at, size_t row, uint32_t i) {
  const float* r = &at.rotation[3 * row];
  return (r[0] * shell.x[i] + r[1] * shell.y[i]) + (r[2] * shell.z[i] + at.translation[row]);
}

template <class Map>
size_t scan_one_by_one(const Map& map, const Limits& limits, const Pointshell& shell,
                       const ShellInVoxels& at, uint32_t first, uint32_t end,
                       std::span<VoxelHit> hits, size_t n) {
  for (uint32_t i = first; i < end && n < hits.size(); ++i) {
    VoxelIndex voxel{};
    bool inside = true;
    for (size_t k = 0; k < 3; ++k) {
      const float q = coordinate(shell, at, k, i);
      inside &= q >= 0 && q < limits[k];
      if (inside) voxel[k] = static_cast<int32_t>(q);
    }
    const Voxel found = inside ? map.at(voxel) : Voxel::kFree;
    // written in any case: which points are free cannot be foretold
    hits[n] = {i << 2 | static_cast<uint32_t>(found)};
    n += found != Voxel::kFree ? 1 : 0;
  }
  return n;
}

}  // namespace haptic
