// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/near_features.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Number of triangles that must agree before a feature counts as a local minimum.
size_t ring_size(const TriangleMesh& mesh, const Feature& feature) {
  HAPTIC_ASSERT(feature.kind != FeatureKind::kEdge || feature.index < mesh.edge_faces.size());
  HAPTIC_ASSERT(feature.kind != FeatureKind::kVertex || feature.index < mesh.vertex_valence.size());
  switch (feature.kind) {
    case FeatureKind::kFace:
      return 1;
    case FeatureKind::kEdge:
      return mesh.edge_faces[feature.index][1] == kNoFace ? 1 : 2;
    case FeatureKind::kVertex:
      return mesh.vertex_valence[feature.index];
  }
  return 1;
}

}  // namespace

NearResult near_features(const MeshShape& shape, const Vec3& p_O, double radius,
                         NearScratch& scratch, std::span<NearFeature> out) {
  const size_t seen = triangles_facing(shape, p_O, radius, scratch.triangles);
  NearResult result{.truncated = seen > scratch.triangles.size()};
  const auto begin = scratch.triangles.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(std::min(seen, scratch.triangles.size()));

  // equal features adjacent, so that a run counts the triangles that agree
  std::sort(begin, end, [](const ClosestPoint& a, const ClosestPoint& b) {
    return a.feature.id() != b.feature.id() ? a.feature.id() < b.feature.id()
                                            : a.triangle < b.triangle;
  });
  size_t n_features = 0;
  for (auto it = begin; it != end;) {
    const auto next =
        std::find_if(it, end, [&](const ClosestPoint& c) { return !(c.feature == it->feature); });
    const bool agreed = static_cast<size_t>(next - it) == ring_size(shape.mesh, it->feature);
    const Vec3 outward_O = agreed ? pseudo_normal(shape.mesh, it->feature) : Vec3{};
    const Vec3 away_O = p_O - it->point_O;
    if (agreed && dot(away_O, outward_O) >= 0) {
      const bool face = it->feature.kind == FeatureKind::kFace;
      const Vec3 normal_O = face || it->distance < kOnSurface ? outward_O : away_O / it->distance;
      HAPTIC_ASSERT(n_features < scratch.features.size());
      scratch.features[n_features++] = {*it, normal_O};
    }
    it = next;
  }
  result.count = std::min(n_features, out.size());
  result.left_out = n_features - result.count;
  std::partial_sort_copy(scratch.features.begin(),
                         scratch.features.begin() + static_cast<std::ptrdiff_t>(n_features),
                         out.begin(), out.end(), [](const NearFeature& a, const NearFeature& b) {
                           return a.closest.distance < b.closest.distance;
                         });
  return result;
}

}  // namespace haptic
