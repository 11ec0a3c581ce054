// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/query/convex/hull_pair.h"

namespace haptic {

/// A facet of the Minkowski difference A ⊕ (−B), which is a vertex of the overlay of the Gauss maps
/// of A and −B: (face, vertex), (vertex, face) or (edge, edge); where faces or edges are parallel,
/// (face, edge) or (face, face), so that coplanar facets are one. Side 0 is A, side 1 is B, each in
/// its own frame.
struct OverlayVertex {
  std::array<HullFeature, 2> feature;
  std::array<Vec3, 2> normal;  // n in the frame of A, −n in that of B: outward for each; unit
  double depth = 0;  // support h_A(n) + h_B(−n): from the origin to the facet's plane [m]
};

/// An arc of the overlay that leaves an overlay vertex: the normals of an edge of one hull, towards
/// the face of the half-edge's twin, as far as the other hull's vertex is its support.
struct OverlayArc {
  int side = 0;         // whose edge it is
  uint32_t edge = 0;    // half-edge
  uint32_t vertex = 0;  // of the other side
  Vec3 tangent;         // its direction at the overlay vertex, in the frame of the side
  double length2 = 0;   // |tangent|²
  double extent = 0;  // tangent · (edge − vertex): how far the facet reaches that way [m], scaled
};

/// The overlay of the Gauss maps of two hulls at one pose, computed where one looks: each arc is
/// followed from a vertex in the plane of its great circle, by homogeneous coordinates, so that 90
/// degrees are as good as any other angle (Kim, Lin, Manocha 2002 project centrally around the
/// current vertex instead, at each step anew).
class GaussOverlay {
 public:
  explicit GaussOverlay(const HullPair& pair) : pair_(pair), R_BA_(transpose(pair.R_AB)) {}

  const Hull& hull(int side) const { return pair_.hull(side); }
  /// A direction of one side's frame in that of the other, for which it is inward.
  Vec3 across(int side, const Vec3& v) const { return -(side == 0 ? R_BA_ * v : pair_.R_AB * v); }
  /// A vertex of the other side in the frame of `side`.
  Vec3 opposite(int side, uint32_t vertex) const;

  /// The overlay vertex of two features, (face, vertex) by the vertex's nearest support; false
  /// where they are none, as two edges whose arcs do not cross.
  bool at(const HullFeature& a, const HullFeature& b, OverlayVertex& out) const;
  /// Support of a unit direction in A: any direction bounds the depth from above. [m]
  double support(const Vec3& normal_A, uint32_t& vertex_a, uint32_t& vertex_b) const;
  /// An overlay vertex near the direction, no deeper: of the region of the two vertices, which must
  /// be its supports.
  OverlayVertex near(const Vec3& normal_A, uint32_t vertex_a, uint32_t vertex_b) const;

  /// Finds parallel features, then calls use(arc) for each arc that leaves the vertex.
  template <class Use>
  void for_arcs(OverlayVertex& at, const Use& use) const;
  /// The overlay vertex at the arc's other end.
  OverlayVertex end_of(const OverlayVertex& from, const OverlayArc& arc) const;

 private:
  void join_parallel(OverlayVertex& at, int side) const;
  OverlayArc arc_at(const OverlayVertex& at, int side, uint32_t edge, uint32_t vertex) const;

  const HullPair& pair_;
  Mat3 R_BA_;
};

template <class Use>
void GaussOverlay::for_arcs(OverlayVertex& at, const Use& use) const {
  join_parallel(at, 0);
  join_parallel(at, 1);
  for (int side = 0; side < 2; ++side) {
    const HullFeature& feature = at.feature[static_cast<size_t>(side)];
    const HullFeature& other = at.feature[static_cast<size_t>(1 - side)];
    const uint32_t vertex = corner_of(hull(1 - side), other);
    if (feature.kind == HullPart::kEdge) {
      use(arc_at(at, side, feature.index, vertex));
      use(arc_at(at, side, hull(side).edges[feature.index].twin, vertex));
    } else if (feature.kind == HullPart::kFace) {
      const HullFace& face = hull(side).faces[feature.index];
      for (uint32_t k = 0; k < face.n_edges; ++k) {
        use(arc_at(at, side, face.first_edge + k, vertex));
      }
    }
  }
}

}  // namespace haptic
