// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle_pairs.h"

#include <array>
#include <cmath>

namespace haptic {
namespace {

// axes in floats are orthonormal to 1e-6; each of the tests below adds a few such errors
constexpr double kAxisSlack = 1e-5;
constexpr double kRounding = 1e-14;  // of coordinates in double, moved

struct NodePair {
  const ObbNode *a = nullptr, *b = nullptr;
};

double size_of(const CompactObb& box) {
  return static_cast<double>(box.half[0]) + static_cast<double>(box.half[1]) +
         static_cast<double>(box.half[2]);
}

/// Both halves of the pair, one of them one level further down.
std::array<NodePair, 2> opened(const NodePair& pair, const ObbTree& tree_A, const ObbTree& tree_B) {
  const auto& [a, b] = pair;
  if (b->count > 0 || (a->count == 0 && size_of(a->box) >= size_of(b->box))) {
    return {NodePair{&tree_A.nodes[a->first], b}, NodePair{&tree_A.nodes[a->first + 1], b}};
  }
  return {NodePair{a, &tree_B.nodes[b->first]}, NodePair{a, &tree_B.nodes[b->first + 1]}};
}

}  // namespace

Corners corners_of(const TriangleMesh& mesh, uint32_t triangle) {
  const Triangle& t = mesh.triangles[triangle];
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

Corners corners_of(const TriangleMesh& mesh, uint32_t triangle, const Pose& X_AB) {
  const Triangle& t = mesh.triangles[triangle];
  return {X_AB * mesh.vertices[t[0]], X_AB * mesh.vertices[t[1]], X_AB * mesh.vertices[t[2]]};
}

bool boxes_may_meet(const CompactObb& a, const CompactObb& b, const Pose& X_AB) {
  const Obb box_a = a.unpacked(), box_b = b.unpacked();
  const Vec3 way = X_AB * box_b.centre_O - box_a.centre_O, t = box_a.R_BO * way;
  // R[i][j]: axis j of b along axis i of a
  Vec3 R[3];
  for (int j = 0; j < 3; ++j) {
    const Vec3 column = box_a.R_BO * rotate(X_AB.q, box_b.R_BO.row[j]);
    R[0][j] = column.x, R[1][j] = column.y, R[2][j] = column.z;
  }
  const Vec3 &h = box_a.half, &g = box_b.half;
  const double pad = kAxisSlack * (size_of(a) + size_of(b)) +
                     kRounding * (norm(X_AB.p) + norm(box_a.centre_O) + norm(box_b.centre_O));
  // written so that what is not a number keeps nothing out
  for (int i = 0; i < 3; ++i) {
    const Vec3& row = R[i];
    const double reach_b = g.x * std::fabs(row.x) + g.y * std::fabs(row.y) + g.z * std::fabs(row.z);
    if (std::fabs(t[i]) > h[i] + reach_b + pad) return false;
  }
  for (int j = 0; j < 3; ++j) {
    const Vec3 column{R[0][j], R[1][j], R[2][j]};
    const double reach_a =
        h.x * std::fabs(column.x) + h.y * std::fabs(column.y) + h.z * std::fabs(column.z);
    if (std::fabs(dot(t, column)) > reach_a + g[j] + pad) return false;
  }
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach = h[i1] * std::fabs(R[i2][j]) + h[i2] * std::fabs(R[i1][j]) +
                           g[j1] * std::fabs(R[i][j2]) + g[j2] * std::fabs(R[i][j1]);
      if (std::fabs(t[i2] * R[i1][j] - t[i1] * R[i2][j]) > reach + pad) return false;
    }
  }
  return true;
}

size_t triangle_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                      std::span<TrianglePair> out) {
  const ObbTree &tree_A = shape_A.tree, &tree_B = shape_B.tree;
  if (tree_A.nodes.empty() || tree_B.nodes.empty() || !is_finite(X_AB)) return 0;
  size_t found = 0;
  const auto test_leaves = [&](const ObbNode& a, const ObbNode& b) {
    for (uint32_t j = 0; j < b.count; ++j) {
      const uint32_t triangle_b = tree_B.order[b.first + j];
      const Corners corners_b = corners_of(shape_B.mesh, triangle_b, X_AB);
      for (uint32_t i = 0; i < a.count; ++i) {
        const uint32_t triangle_a = tree_A.order[a.first + i];
        if (!triangles_meet(corners_of(shape_A.mesh, triangle_a), corners_b)) continue;
        if (found < out.size()) out[found] = {triangle_a, triangle_b};
        ++found;
      }
    }
  };
  // each level opens one pair into two
  std::array<NodePair, 2 * kMaxTreeDepth + 2> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = {&tree_A.nodes[0], &tree_B.nodes[0]};
  while (n_waiting > 0) {
    const NodePair pair = waiting[--n_waiting];
    if (!boxes_may_meet(pair.a->box, pair.b->box, X_AB)) continue;
    if (pair.a->count > 0 && pair.b->count > 0) {
      test_leaves(*pair.a, *pair.b);
      continue;
    }
    for (const NodePair& half : opened(pair, tree_A, tree_B)) waiting[n_waiting++] = half;
  }
  return found;
}

}  // namespace haptic
