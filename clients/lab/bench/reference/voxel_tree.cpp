// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/voxel_tree.h"

#include <algorithm>

#include "contact/query/volume/scalar_scan.h"

namespace haptic {
namespace {

constexpr uint32_t kAllFree = 0, kAllInterior = 1;  // bricks and nodes

/// Index in the tree for each brick of the map; uniform bricks are shared.
std::vector<uint32_t> take_bricks(const Voxmap& map, VoxelTreeData& tree) {
  tree.bricks.assign(map.data.begin(), map.data.begin() + 2);
  std::vector<uint32_t> number_of(map.data.size());
  for (size_t i = 0; i < map.data.size(); ++i) {
    const auto like = std::find(tree.bricks.begin(), tree.bricks.begin() + 2, map.data[i]);
    number_of[i] = static_cast<uint32_t>(like - tree.bricks.begin());
    if (number_of[i] <= kAllInterior) continue;
    number_of[i] = static_cast<uint32_t>(tree.bricks.size());
    tree.bricks.push_back(map.data[i]);
  }
  return number_of;
}

/// The bricks below a child of the root; free beyond the map.
TreeNode gather_node(const Voxmap& map, const std::vector<uint32_t>& number_of,
                     const VoxelIndex& first) {
  TreeNode node;
  for (size_t child = 0; child < kTreeChildren; ++child) {
    const size_t x = static_cast<size_t>(first[0]) + child % kTreeSide,
                 y = static_cast<size_t>(first[1]) + child / kTreeSide % kTreeSide,
                 z = static_cast<size_t>(first[2]) + child / (kTreeSide * kTreeSide);
    const auto nx = static_cast<size_t>(map.bricks[0]), ny = static_cast<size_t>(map.bricks[1]),
               nz = static_cast<size_t>(map.bricks[2]);
    const bool inside = x < nx && y < ny && z < nz;
    node[child] = inside ? number_of[map.index[(z * ny + y) * nx + x]] : kAllFree;
  }
  return node;
}

}  // namespace

VoxelTreeData build_voxel_tree(const Voxmap& map) {
  VoxelTreeData tree;
  if (map.data.empty()) return tree;
  const std::vector<uint32_t> number_of = take_bricks(map, tree);
  tree.nodes.resize(2);
  tree.nodes[kAllInterior].fill(kAllInterior);
  for (size_t k = 0; k < 3; ++k) tree.roots[k] = (map.bricks[k] + kTreeSide - 1) / kTreeSide;
  VoxelIndex i;
  for (i[2] = 0; i[2] < tree.roots[2]; ++i[2]) {
    for (i[1] = 0; i[1] < tree.roots[1]; ++i[1]) {
      for (i[0] = 0; i[0] < tree.roots[0]; ++i[0]) {
        const TreeNode node =
            gather_node(map, number_of, {kTreeSide * i[0], kTreeSide * i[1], kTreeSide * i[2]});
        const auto like = std::find(tree.nodes.begin(), tree.nodes.begin() + 2, node);
        tree.root.push_back(static_cast<uint32_t>(like - tree.nodes.begin()));
        if (tree.root.back() > kAllInterior) {
          tree.root.back() = static_cast<uint32_t>(tree.nodes.size());
          tree.nodes.push_back(node);
        }
      }
    }
  }
  return tree;
}

size_t scan_voxels(const VoxelTree& tree, const Pointshell& shell, const ShellInVoxels& at,
                   uint32_t first, uint32_t count, std::span<VoxelHit> hits, size_t n) {
  if (tree.bricks.empty()) return n;
  const Limits limits = limits_of(tree.roots, kBrickSide * kTreeSide);
  return scan_one_by_one(tree, limits, shell, at, first, first + count, hits, n);
}

}  // namespace haptic
