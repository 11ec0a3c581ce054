// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/triangle_boxes.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace haptic {
namespace {

constexpr size_t kBoxTriangles = 4;  // of a leaf
constexpr size_t kMostDepth = 40;    // halving 2^32 triangles ends before

/// Fills in node i of the triangles [first, end) of the order, and those below it.
void build_node(TriangleBoxes& tree, size_t i, uint32_t first, uint32_t end) {
  if (tree.nodes.size() <= i) {
    tree.nodes.resize(i + 1);
    tree.first_of.resize(2 * (i + 1));
  }
  Box box = tree.boxes[tree.order[first]];
  for (uint32_t k = first; k < end; ++k) box.add(tree.boxes[tree.order[k]]);
  tree.nodes[i] = box;
  tree.first_of[2 * i] = first;
  tree.first_of[2 * i + 1] = end;
  if (end - first <= kBoxTriangles) return;
  const int axis = longest_axis(box.size());
  const uint32_t middle = first + (end - first) / 2;
  const auto at = [&](uint32_t k) { return tree.order.begin() + k; };
  std::nth_element(at(first), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    const double x = tree.boxes[a].lower[axis] + tree.boxes[a].upper[axis];
    const double y = tree.boxes[b].lower[axis] + tree.boxes[b].upper[axis];
    return x != y ? x < y : a < b;
  });
  build_node(tree, 2 * i + 1, first, middle);
  build_node(tree, 2 * i + 2, middle, end);
}

}  // namespace

TriangleBoxes build_triangle_boxes(const TriangleMesh& mesh) {
  TriangleBoxes tree;
  const auto n = static_cast<uint32_t>(mesh.triangles.size());
  tree.boxes.reserve(n);
  for (uint32_t t = 0; t < n; ++t) tree.boxes.push_back(box_around(corners_of(mesh, t)));
  tree.order.resize(n);
  std::iota(tree.order.begin(), tree.order.end(), 0);
  if (n > 0) build_node(tree, 0, 0, n);
  return tree;
}

bool any_near(const TriangleBoxes& tree, const Box& box, const std::function<bool(uint32_t)>& f) {
  if (tree.nodes.empty()) return false;
  std::array<size_t, kMostDepth> waiting{0};
  size_t n = 1;
  while (n > 0) {
    const size_t i = waiting[--n];
    if (!tree.nodes[i].overlaps(box)) continue;
    const uint32_t first = tree.first_of[2 * i], end = tree.first_of[2 * i + 1];
    if (end - first > kBoxTriangles) {
      waiting[n++] = 2 * i + 2;
      waiting[n++] = 2 * i + 1;
      continue;
    }
    for (uint32_t k = first; k < end; ++k) {
      if (tree.boxes[tree.order[k]].overlaps(box) && f(tree.order[k])) return true;
    }
  }
  return false;
}

}  // namespace haptic
