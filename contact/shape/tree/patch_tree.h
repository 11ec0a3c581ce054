// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

inline constexpr size_t kPatchLanes = 8;  // children of a node, and triangles of a leaf

/// Eight patches of the surface side by side, so that one test serves all of them. Each is held by
/// an axis-parallel box, by a slab low ≤ axis·q ≤ high, and by a cone: a surface point q of the
/// patch that is locally nearest to p has |axis·(p − q)| ≥ cos·|p − q|. All in float, rounded
/// outwards: they hold for the mesh in double.
struct PatchNode {
  using Lanes = std::array<float, kPatchLanes>;
  std::array<Lanes, 3> lower, upper;  // by coordinate
  std::array<Lanes, 3> axis;          // mean normal, at most of unit length
  Lanes low, high;
  Lanes cos_squared;                        // 0: locally nearest points in every direction
  std::array<uint32_t, kPatchLanes> child;  // a node, or kPatchLeaf | leaf
  std::array<uint32_t, 8> unused{};
};

inline constexpr uint32_t kPatchLeaf = 1u << 31;
inline constexpr uint32_t kNoPatch = ~0u;  // a lane that holds nothing

/// Up to eight triangles, coarse but compact, to tell which of them are worth looking up in the
/// mesh. A corner is origin + step·(x, y, z), at most a step from where it really is, its three
/// numbers in one word, 10 bits each, x lowest; a triangle too thin for arithmetic in float is
/// stored as a point.
struct PatchLeaf {
  using Lanes = std::array<uint32_t, kPatchLanes>;
  std::array<float, 3> origin;
  float step = 0;
  std::array<Lanes, 3> corners;
  Lanes triangle;  // kNoFace beyond the last one
};

inline constexpr uint32_t kPatchSteps = 1023;  // of the longest side of a leaf

/// Eight-wide tree over the triangles of a mesh for questions about distance: boxes as in any
/// bounding volume hierarchy, normal cones after Johnson & Cohen 2001 ("Spatialized normal cone
/// hierarchies"), here widened to every face that shares a vertex with the patch, so that edges and
/// vertices on its rim are judged right. About 27 bytes a triangle. A view.
struct PatchTree {
  std::span<const PatchNode> nodes;  // root first, children after their parent
  std::span<const PatchLeaf> leaves;
};

inline constexpr int kMaxPatchDepth = 12;  // 8¹¹ leaves are more than there are triangles

struct PatchTreeData {
  std::vector<PatchNode> nodes;
  std::vector<PatchLeaf> leaves;
  PatchTree view() const { return {nodes, leaves}; }
};

/// Builds the tree, full but for the last levels, by cuts across the longest axis; start-up only.
PatchTreeData build_patch_tree(const TriangleMesh& mesh);

}  // namespace haptic
