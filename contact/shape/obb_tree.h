// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/patch_tree.h"
#include "contact/shape/triangle_mesh.h"
#include "proto/math/mat3.h"

namespace haptic {

/// Oriented bounding box: rows of R_BO are its axes in O, so p_B = R_BO (p_O − centre_O).
struct Obb {
  Mat3 R_BO;
  Vec3 centre_O;
  Vec3 half;  // half extents along its axes [m]
};

/// Node of the tree: an inner node's children are `first` and `first + 1`; a leaf holds `count`
/// entries of ObbTree::order from `first`.
struct ObbNode {
  Obb box;
  uint32_t first = 0;
  uint32_t count = 0;  // 0: inner node
};

/// OBB tree over the triangles of a mesh (Gottschalk, Lin, Manocha 1996): boxes from the
/// area-weighted covariance of the triangles, split at the mean along the longest axis. A view.
struct ObbTree {
  std::span<const ObbNode> nodes;   // root first; empty for no triangles
  std::span<const uint32_t> order;  // triangle indices, grouped by leaf
};

inline constexpr int kMaxTreeDepth = 64;  // build_obb_tree never goes deeper: traversal stacks

struct ObbTreeData {
  std::vector<ObbNode> nodes;
  std::vector<uint32_t> order;
  ObbTree view() const { return {nodes, order}; }
};

/// Builds the tree; start-up only. Falls back to a median split where the mean does not separate.
ObbTreeData build_obb_tree(const TriangleMesh& mesh);

/// What a query needs of one object.
struct MeshShape {
  TriangleMesh mesh;
  ObbTree tree;
  PatchTree patches;
};

}  // namespace haptic
