// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/hull_pair.h"

namespace haptic {

bool is_real(const Hull& hull, const HullFeature& feature) {
  const auto on_surface = [&](uint32_t edge) {
    return hull.faces[hull.edges[edge].face].is_virtual == 0;
  };
  if (feature.kind == HullPart::kFace) return hull.faces[feature.index].is_virtual == 0;
  if (feature.kind == HullPart::kEdge) {
    return on_surface(feature.index) || on_surface(hull.edges[feature.index].twin);
  }
  bool is_any = false;
  for_edges_around(hull, feature.index, [&](uint32_t edge) { is_any |= on_surface(edge); });
  return is_any;
}

uint32_t corner_of(const Hull& hull, const HullFeature& feature) {
  if (feature.kind == HullPart::kVertex) return feature.index;
  if (feature.kind == HullPart::kEdge) return hull.edges[feature.index].from;
  return hull.edges[hull.faces[feature.index].first_edge].from;
}

bool is_feature(const Hull& hull, const HullFeature& feature) {
  switch (feature.kind) {
    case HullPart::kVertex:
      return feature.index < hull.vertices.size();
    case HullPart::kEdge:
      return feature.index < hull.edges.size();
    case HullPart::kFace:
      return feature.index < hull.faces.size();
  }
  return false;
}

}  // namespace haptic
