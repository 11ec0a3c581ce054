// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "contact/shape/mesh/box.h"

namespace haptic {

/// A tree of axis-aligned boxes around the triangles of a mesh, for the baker: which triangles are
/// near a box. The children of node i are 2i + 1 and 2i + 2.
struct TriangleBoxes {
  std::vector<Box> nodes;
  std::vector<uint32_t> order;     // triangles, those of a leaf consecutive
  std::vector<Box> boxes;          // of each triangle
  std::vector<uint32_t> first_of;  // of each node: its first place in `order`, then the end
};

TriangleBoxes build_triangle_boxes(const TriangleMesh& mesh);

/// Calls f for each triangle whose box meets this one, until f returns true. Returns true if it
/// did.
bool any_near(const TriangleBoxes& tree, const Box& box, const std::function<bool(uint32_t)>& f);

}  // namespace haptic
