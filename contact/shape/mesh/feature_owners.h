// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Assigns each vertex and each edge of a mesh to one of the triangles that share it. Two features
/// need to be tested only if the triangles that own them come near each other: three to four times
/// fewer tests than for all pairs of triangles (Curtis, Tamstorf, Manocha 2008).
class FeatureOwners {
 public:
  explicit FeatureOwners(const TriangleMesh& mesh);  // start-up only

  bool has_vertex(uint32_t triangle, int i) const { return ((bits_[triangle] >> i) & 1) != 0; }
  /// Edge i joins corners i and (i + 1) % 3.
  bool has_edge(uint32_t triangle, int i) const { return ((bits_[triangle] >> (3 + i)) & 1) != 0; }

 private:
  std::vector<uint8_t> bits_;  // per triangle: bits 0–2 vertices, 3–5 edges
};

}  // namespace haptic
