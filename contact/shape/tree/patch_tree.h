// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

inline constexpr size_t kPatchLanes = 8;  // children per node, and triangles per leaf

/// Eight patches of the surface as a structure of arrays, so that one test covers all. Each is
/// bounded by an axis-aligned box, by a slab low ≤ axis·q ≤ high, and by a normal cone: a point q
/// of the patch that is a local minimum of the distance to p satisfies |axis·(p − q)| ≥ cos·|p −
/// q|. In float, rounded outwards: valid for the mesh in double.
struct PatchNode {
  using Lanes = std::array<float, kPatchLanes>;
  std::array<Lanes, 3> lower, upper;  // by coordinate
  std::array<Lanes, 3> axis;          // mean normal, length at most 1
  Lanes low, high;
  Lanes cos_squared;                        // 0: local minima in every direction
  std::array<uint32_t, kPatchLanes> child;  // a node, or kPatchLeaf | leaf
  std::array<uint32_t, 8> unused{};
};

inline constexpr uint32_t kPatchLeaf = 1u << 31;  // bit of a child that is a leaf
inline constexpr uint32_t kNoPatch = ~0u;         // an unused lane

/// Up to eight triangles in compact form, to decide which of them need to be looked up in the mesh.
/// A corner is origin + step·(x, y, z), with an error of at most one step; its three numbers are in
/// one word, 10 bits each, x lowest. Triangles too thin for float arithmetic are stored as a point.
struct PatchLeaf {
  using Lanes = std::array<uint32_t, kPatchLanes>;
  std::array<float, 3> origin;
  float step = 0;
  std::array<Lanes, 3> corners;
  Lanes triangle;  // kNoFace in unused lanes
};

inline constexpr uint32_t kPatchSteps = 1023;  // along the longest side of a leaf

/// Eight-wide tree over the triangles of a mesh for distance queries: boxes as in any bounding
/// volume hierarchy, normal cones after Johnson & Cohen 2001, here widened to every face that
/// shares a vertex with the patch, so that minima on edges and vertices of its rim are kept. About
/// 27 bytes per triangle.
template <template <class> class Array>
struct PatchTreeOf {
  Array<PatchNode> nodes;  // root first, children after their parent
  Array<PatchLeaf> leaves;

  PatchTreeOf<ArrayView> view() const { return {nodes, leaves}; }
};
using PatchTree = PatchTreeOf<ArrayView>;
using PatchTreeData = PatchTreeOf<ArrayData>;

inline constexpr int kMaxPatchDepth = 12;  // 8¹¹ leaves exceed any number of triangles

/// Builds the tree, full except for the last levels, by splits across the longest axis; at start-up
/// only.
PatchTreeData build_patch_tree(const TriangleMesh& mesh);

}  // namespace haptic
