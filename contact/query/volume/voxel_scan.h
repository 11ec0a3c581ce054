// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"
#include "proto/math/pose.h"

namespace haptic {

/// A point of the shell in a voxel that is not free.
struct VoxelHit {
  uint32_t packed = 0;
  uint32_t point() const { return packed >> 2; }
  Voxel voxel() const { return static_cast<Voxel>(packed & 3u); }
};

/// From the frame T of a shell into the voxels of a map: q = R p + t, in voxels, in float.
struct ShellInVoxels {
  std::array<float, 9> rotation;  // row major, over the voxel's size
  std::array<float, 3> translation;
};
ShellInVoxels shell_in_voxels(const Voxmap& map, const Pose& X_OT);

/// Which way the points are looked up; the result is the same to the bit. Lanes are used as long as
/// there is room for 64 hits more.
enum class ScanPath { kScalar, kLanes };

/// kLanes where the processor has AVX2.
ScanPath fastest_scan();

/// Looks up the voxels of the points first … first + count − 1, in order, and appends those that
/// are not free to `hits` from place `n` on, as far as there is room for all of them. Returns the
/// new number. Points are rounded to float in voxels: off by at most 1e-4 of a voxel in a map of
/// 1024. Points outside the map are free. What lies in `hits` beyond the new number is undefined.
size_t scan_voxels(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                   uint32_t first, uint32_t count, ScanPath path, std::span<VoxelHit> hits,
                   size_t n);

}  // namespace haptic
