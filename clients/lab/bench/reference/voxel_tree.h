// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/query/volume/voxel_scan.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

inline constexpr int kTreeSide = 8;  // children along an edge of a node: 2^N, N = 3
inline constexpr size_t kTreeChildren = kTreeSide * kTreeSide * kTreeSide;

/// Brick indices of a node, x fastest.
using TreeNode = std::array<uint32_t, kTreeChildren>;

/// A voxmap as a generalised octree of fixed depth three with 512 children per node (McNeely,
/// Puterbaugh, Troy 1999): three loads per voxel, memory only for nodes and bricks that are neither
/// all free nor all interior. The root has as many children as the map needs, 8³ for 512 voxels, so
/// the depth is three for any size. A view.
struct VoxelTree {
  VoxelIndex roots{};                  // children of the root along each axis
  std::span<const uint32_t> root;      // node of each child, x fastest
  std::span<const TreeNode> nodes;     // the first two are all free and all interior
  std::span<const VoxelBrick> bricks;  // likewise

  /// kFree beyond the map.
  Voxel at(const VoxelIndex& i) const {
    constexpr int kNodeBits = 2 * kBrickBits;
    for (size_t k = 0; k < 3; ++k) {
      if (i[k] < 0 || i[k] >= roots[k] << kNodeBits) return Voxel::kFree;
    }
    const auto above = [&](size_t k) { return static_cast<size_t>(i[k] >> kNodeBits); };
    const size_t place =
        (above(2) * static_cast<size_t>(roots[1]) + above(1)) * static_cast<size_t>(roots[0]) +
        above(0);
    // bricks of a node are numbered like the voxels of a brick
    const uint32_t child =
        voxel_in_brick({i[0] >> kBrickBits, i[1] >> kBrickBits, i[2] >> kBrickBits});
    return bricks[nodes[root[place]][child]].at(voxel_in_brick(i));
  }
};

struct VoxelTreeData {
  VoxelIndex roots{};
  std::vector<uint32_t> root;
  std::vector<TreeNode> nodes;
  std::vector<VoxelBrick> bricks;

  VoxelTree view() const { return {roots, root, nodes, bricks}; }
  size_t bytes() const {
    return root.size() * sizeof(uint32_t) + nodes.size() * sizeof(TreeNode) +
           bricks.size() * sizeof(VoxelBrick);
  }
};

/// Builds the tree of a map, at start-up only. An empty map gives an empty tree.
VoxelTreeData build_voxel_tree(const Voxmap& map);

/// As scan_voxels of the tree's map, one point after the other; `at` is made for the map.
size_t scan_voxels(const VoxelTree& tree, const Pointshell& shell, const ShellInVoxels& at,
                   uint32_t first, uint32_t count, std::span<VoxelHit> hits, size_t n);

}  // namespace haptic
