// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/mat3.h"

namespace haptic {

/// Oriented bounding box: rows of R_BO are its axes in O, so p_B = R_BO (p_O − centre_O).
struct Obb {
  Mat3 R_BO;
  Vec3 centre_O;
  Vec3 half;  // half extents along its axes [m]
};

/// An oriented box that shares a cache line with its node: in float, rounded so that it contains
/// what it was fitted to. R_BO is orthonormal to 1e-6 only, so distances measured in its frame need
/// an allowance (kCompactSlack); containment and overlap tests need none. Outside the range of
/// float, R_BO is zero, half is infinite, and the box excludes nothing.
struct CompactObb {
  std::array<float, 9> columns_BO{};  // R_BO, column by column
  std::array<float, 3> half{};        // half extents along its axes [m]
  std::array<float, 3> centre_O{};

  Obb unpacked() const;
};

/// factor for squared lengths measured in the frame of a CompactObb: bounds their error
inline constexpr double kCompactSlack = 1 + 1e-5;

/// Node of the tree: the children of an inner node are `first` and `first + 1`; a leaf has `count`
/// entries of ObbTree::order from `first`.
struct ObbNode {
  CompactObb box;
  uint32_t first : 28 = 0;
  uint32_t count : 4 = 0;  // 0: inner node
};
static_assert(sizeof(ObbNode) == 64);

inline constexpr size_t kLeafTriangles = 4;  // per leaf, at most

/// OBB tree over the triangles of a mesh (Gottschalk, Lin, Manocha 1996): boxes from the
/// area-weighted covariance of the triangles, split at the mean along the longest axis.
template <template <class> class Array>
struct ObbTreeOf {
  Array<ObbNode> nodes;   // root first; empty for no triangles
  Array<uint32_t> order;  // triangle indices, grouped by leaf

  ObbTreeOf<ArrayView> view() const { return {nodes, order}; }
};
using ObbTree = ObbTreeOf<ArrayView>;
using ObbTreeData = ObbTreeOf<ArrayData>;

inline constexpr int kMaxTreeDepth = 64;  // never exceeded; size of traversal stacks
inline constexpr size_t kMaxTreeTriangles = size_t{1} << 27;  // node indices have 28 bits

/// Runs both functions, in parallel if it can.
using RunBoth =
    std::function<void(const std::function<void()>& first, const std::function<void()>& second)>;

inline void run_in_turn(const std::function<void()>& first, const std::function<void()>& second) {
  first();
  second();
}

/// Builds the tree; at start-up only. Falls back to a median split where the mean does not
/// separate. The result does not depend on `run_both`. Throws std::length_error for more than
/// kMaxTreeTriangles.
ObbTreeData build_obb_tree(const TriangleMesh& mesh, const RunBoth& run_both = run_in_turn);

}  // namespace haptic
