// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/patch_tree.h"

#include <catch2/catch.hpp>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

double lane_at(const std::array<PatchNode::Lanes, 3>& rows, int k, size_t lane) {
  return static_cast<double>(rows[static_cast<size_t>(k)][lane]);
}

/// Triangles below one lane.
std::vector<uint32_t> triangles_below(const PatchTree& tree, uint32_t child) {
  std::vector<uint32_t> triangles;
  if (child == kNoPatch) return triangles;
  if ((child & kPatchLeaf) != 0) {
    for (const uint32_t t : tree.leaves[child & ~kPatchLeaf].triangle) {
      if (t != kNoFace) triangles.push_back(t);
    }
    return triangles;
  }
  for (const uint32_t next : tree.nodes[child].child) {
    for (const uint32_t t : triangles_below(tree, next)) triangles.push_back(t);
  }
  return triangles;
}

/// Box and slab hold the vertices; the cone holds the normals of all faces that share one of them.
void check_lane(const TriangleMesh& mesh, const PatchNode& node, size_t lane,
                const std::vector<uint32_t>& triangles) {
  const Vec3 axis{lane_at(node.axis, 0, lane), lane_at(node.axis, 1, lane),
                  lane_at(node.axis, 2, lane)};
  CHECK(norm(axis) <= 1);
  std::vector<bool> mine(mesh.vertices.size(), false);
  bool holds = true;
  for (const uint32_t t : triangles) {
    for (const uint32_t v : mesh.triangles[t]) {
      mine[v] = true;
      const Vec3& q = mesh.vertices[v];
      for (int k = 0; k < 3; ++k) {
        holds =
            holds && q[k] >= lane_at(node.lower, k, lane) && q[k] <= lane_at(node.upper, k, lane);
      }
      holds = holds && dot(axis, q) >= static_cast<double>(node.low[lane]) &&
              dot(axis, q) <= static_cast<double>(node.high[lane]);
    }
  }
  const double cos = std::sqrt(static_cast<double>(node.cos_squared[lane]));
  for (size_t f = 0; cos > 0 && f < mesh.triangles.size(); ++f) {
    const Triangle& tri = mesh.triangles[f];
    if (!mine[tri[0]] && !mine[tri[1]] && !mine[tri[2]]) continue;
    holds = holds && dot(axis, mesh.face_normals[f]) >= cos;
  }
  REQUIRE(holds);
}

void check_patch_tree(const MeshShapeData& shape) {
  const TriangleMesh mesh = shape.mesh.view();
  const PatchTree tree = shape.patches.view();
  std::vector<int> seen(mesh.triangles.size(), 0);
  std::vector<int> parents(tree.nodes.size(), 0);
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    const PatchNode& node = tree.nodes[i];
    for (uint32_t lane = 0; lane < kPatchLanes; ++lane) {
      const auto triangles = triangles_below(tree, node.child[lane]);
      if (node.child[lane] == kNoPatch) continue;
      check_lane(mesh, node, lane, triangles);
      if ((node.child[lane] & kPatchLeaf) != 0) {
        for (const uint32_t t : triangles) ++seen[t];
      } else {
        REQUIRE(node.child[lane] > i);
        REQUIRE(++parents[node.child[lane]] == 1);
      }
    }
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  CHECK(std::count(parents.begin(), parents.end(), 0) == (tree.nodes.empty() ? 0 : 1));
}

double bytes_per_triangle(const MeshShapeData& shape) {
  const size_t bytes = shape.patches.nodes.size() * sizeof(PatchNode) +
                       shape.patches.leaves.size() * sizeof(PatchLeaf);
  return static_cast<double>(bytes) / static_cast<double>(shape.mesh.triangles.size());
}

}  // namespace

TEST_CASE("patch tree: patches hold their triangles, and the normals around them") {
  check_patch_tree(build_shape(make_box({1, 2, 3})));
  check_patch_tree(build_shape(make_grid(0.05, 12)));
  check_patch_tree(build_shape(make_icosphere(0.05, 2)));
  check_patch_tree(build_shape(make_degenerate_soup(3, 300)));
}

TEST_CASE("patch tree: a stored corner is at most a step from where it is") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 3));
  size_t compared = 0;
  for (const PatchLeaf& leaf : shape.patches.leaves) {
    for (size_t lane = 0; lane < kPatchLanes; ++lane) {
      if (leaf.triangle[lane] == kNoFace) continue;
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t word = leaf.corners[c][lane];
        const Vec3 steps(word & kPatchSteps, (word >> 10) & kPatchSteps, word >> 20);
        const Vec3 origin{static_cast<double>(leaf.origin[0]), static_cast<double>(leaf.origin[1]),
                          static_cast<double>(leaf.origin[2])};
        const auto step = static_cast<double>(leaf.step);
        const Vec3& v = shape.mesh.vertices[shape.mesh.triangles[leaf.triangle[lane]][c]];
        REQUIRE(norm(origin + step * steps - v) <= step);
        ++compared;
      }
    }
  }
  CHECK(compared == 3 * shape.mesh.triangles.size());
}

TEST_CASE("patch tree: at most 40 bytes a triangle on large meshes, nothing for none") {
  CHECK(bytes_per_triangle(build_shape(make_icosphere(0.05, 5))) < 40);
  CHECK(bytes_per_triangle(build_shape(make_grid(0.05, 101))) < 40);
  CHECK(build_shape({}).patches.nodes.empty());
  CHECK(build_shape({}).patches.leaves.empty());
}
