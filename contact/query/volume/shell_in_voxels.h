// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "contact/shape/volume/voxmap.h"
#include "proto/math/pose.h"

namespace haptic {

/// A point of the shell in a voxel that is not free.
struct VoxelHit {
  uint32_t packed = 0;
  uint32_t point() const { return packed >> 2; }
  Voxel voxel() const { return static_cast<Voxel>(packed & 3u); }
};

/// Transform from the frame T of a shell to voxels of a map, in float: q = R p + t, in voxels.
struct ShellInVoxels {
  std::array<float, 9> rotation;  // row major, divided by the voxel size
  std::array<float, 3> translation;
};
ShellInVoxels shell_in_voxels(const Voxmap& map, const Pose& X_OT);

}  // namespace haptic
