// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "contact/shape/mesh/arrays.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

inline constexpr double kMostVoxels = 4096;  // along a side of a map

/// State of a voxel, in two bits.
enum class Voxel : uint8_t { kFree = 0, kInterior = 1, kSurface = 2, kProximity = 3 };

using VoxelIndex = std::array<int32_t, 3>;

inline constexpr int kBrickBits = 3;                // of a voxel's index along an edge
inline constexpr int kBrickSide = 1 << kBrickBits;  // voxels along an edge of a brick
inline constexpr size_t kVoxelsAWord = 16;          // of 32 bits, two a voxel

/// 8 × 8 × 8 voxels, x fastest; voxel i is the two bits at 2 (i mod 16) of word i/16.
struct VoxelBrick {
  std::array<uint32_t, kBrickSide * kBrickSide * kBrickSide / kVoxelsAWord> words{};

  Voxel at(uint32_t voxel) const {
    return static_cast<Voxel>(words[voxel / kVoxelsAWord] >> 2 * (voxel % kVoxelsAWord) & 3u);
  }
  void set(uint32_t voxel, Voxel value) {
    uint32_t& word = words[voxel / kVoxelsAWord];
    const uint32_t shift = 2 * (voxel % kVoxelsAWord);
    word = (word & ~(3u << shift)) | static_cast<uint32_t>(value) << shift;
  }
  bool operator==(const VoxelBrick&) const = default;
};

/// Index of a voxel within its brick.
inline uint32_t voxel_in_brick(const VoxelIndex& i) {
  constexpr int kMask = kBrickSide - 1;
  return static_cast<uint32_t>((i[2] & kMask) << 2 * kBrickBits | (i[1] & kMask) << kBrickBits |
                               (i[0] & kMask));
}

/// The space around a mesh in cubes of equal size (McNeely, Puterbaugh, Troy 1999), in sparse
/// bricks: two loads per voxel, memory only for bricks that are neither all free nor all interior.
template <template <class> class Array>
struct VoxmapOf {
  Vec3 lower_O;     // corner of voxel (0, 0, 0)
  double size = 0;  // edge of a voxel [m]
  double voxels_per_metre = 0;
  VoxelIndex bricks{};     // along each axis
  Array<uint32_t> index;   // brick of each place, x fastest
  Array<VoxelBrick> data;  // the first two are all free and all interior

  VoxmapOf<ArrayView> view() const {
    return {lower_O, size, voxels_per_metre, bricks, index, data};
  }
  size_t bytes() const {
    return index.size() * sizeof(uint32_t) + data.size() * sizeof(VoxelBrick);
  }
  bool holds(const VoxelIndex& i) const {
    for (size_t k = 0; k < 3; ++k) {
      if (i[k] < 0 || i[k] >= bricks[k] << kBrickBits) return false;
    }
    return true;
  }
  /// The place of the brick of a voxel that the map holds.
  size_t place_of(const VoxelIndex& i) const {
    const auto at = [&](size_t k) { return static_cast<size_t>(i[k] >> kBrickBits); };
    return (at(2) * static_cast<size_t>(bricks[1]) + at(1)) * static_cast<size_t>(bricks[0]) +
           at(0);
  }
  /// kFree beyond the map.
  Voxel at(const VoxelIndex& i) const {
    return holds(i) ? data[index[place_of(i)]].at(voxel_in_brick(i)) : Voxel::kFree;
  }
  VoxelIndex index_of(const Vec3& p_O) const {
    const Vec3 q = voxels_per_metre * (p_O - lower_O);
    return {static_cast<int32_t>(std::floor(q.x)), static_cast<int32_t>(std::floor(q.y)),
            static_cast<int32_t>(std::floor(q.z))};
  }
  Vec3 centre_of(const VoxelIndex& i) const {
    return lower_O + size * Vec3{i[0] + 0.5, i[1] + 0.5, i[2] + 0.5};
  }
};

using Voxmap = VoxmapOf<ArrayView>;
using VoxmapData = VoxmapOf<ArrayData>;

struct VoxmapOptions {
  double size = 1e-3;     // of a voxel [m]
  int offset_layers = 2;  // layers by which the surface is offset outwards; see build_voxmap
};

/// Bakes the map of a mesh; at start-up only. Every voxel that a triangle meets is surface (exact
/// triangle–box test, widened by a millionth of a voxel); what a flood fill from outside through
/// faces does not reach is interior; free 26-neighbours of the surface are proximity. Then,
/// `offset_layers` times, proximity becomes surface, surface becomes interior, and a new ring
/// becomes proximity: forces begin before the real surfaces can touch. An open mesh has no interior
/// except its own voxels: check mesh.closed first. Empty if the mesh is, or if a side has more than
/// kMostVoxels.
VoxmapData build_voxmap(const TriangleMesh& mesh, const VoxmapOptions& options);

}  // namespace haptic
