// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/feature_owners.h"

#include "proto/math/assert.h"

namespace haptic {

FeatureOwners::FeatureOwners(const TriangleMesh& mesh) : bits_(mesh.triangles.size(), 0) {
  HAPTIC_ASSERT(mesh.triangle_edges.size() == mesh.triangles.size());
  std::vector<bool> has_owner_vertex(mesh.vertices.size()), has_owner_edge(mesh.edge_faces.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t vertex = mesh.triangles[t][i], edge = mesh.triangle_edges[t][i];
      const unsigned takes_vertex = has_owner_vertex[vertex] ? 0 : 1u << i,
                     takes_edge = has_owner_edge[edge] ? 0 : 8u << i;
      bits_[t] = static_cast<uint8_t>(bits_[t] | takes_vertex | takes_edge);
      has_owner_vertex[vertex] = has_owner_edge[edge] = true;
    }
  }
}

}  // namespace haptic
