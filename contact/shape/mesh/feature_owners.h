// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Which triangle answers for each vertex and each edge of a mesh: one of those that share it. Two
/// features need to be asked about only where the two triangles that answer for them come near each
/// other, three to four times fewer questions than by all pairs of triangles (Curtis, Tamstorf,
/// Manocha 2008).
class FeatureOwners {
 public:
  explicit FeatureOwners(const TriangleMesh& mesh);  // start-up only

  bool has_vertex(uint32_t triangle, int i) const { return ((bits_[triangle] >> i) & 1) != 0; }
  /// Edge i joins corners i and (i + 1) % 3.
  bool has_edge(uint32_t triangle, int i) const { return ((bits_[triangle] >> (3 + i)) & 1) != 0; }

 private:
  std::vector<uint8_t> bits_;  // of each triangle
};

}  // namespace haptic
