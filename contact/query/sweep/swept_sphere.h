// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/segment_hit.h"

namespace haptic {

/// A sphere whose centre moves along a straight line in O.
struct SweptSphere {
  Vec3 from_O, to_O;
  double radius = 0;  // > 0 [m]
};

/// First triangle that the sphere runs into: the earliest hit of its centre with the
/// configuration-space obstacle of a triangle, which is two offset faces, three edge cylinders and
/// three vertex spheres (Ruspini, Kolarov, Khatib 1997). Surfaces are one-sided: only a centre in
/// front of the face, or of the pseudo-normal of the edge or vertex, is stopped, and only if it
/// approaches. A sphere that already overlaps is hit at t = 0 if it would go deeper. The three
/// kinds of obstacle overlap at their seams, so there are no cracks; t is exact up to rounding.
/// Ties go to the lower triangle index. Tests the witness first (warm start), then traverses the
/// patch tree along the way up to the earliest hit.
SegmentHit first_sphere_hit(const MeshShape& shape, const SweptSphere& sphere,
                            SegmentWitness& witness);

/// Without a witness; the same answer.
SegmentHit first_sphere_hit(const MeshShape& shape, const SweptSphere& sphere);

/// The sphere against one triangle, up to fraction t of its way; if true, t is set to the hit. The
/// same arithmetic as first_sphere_hit.
bool sphere_enters_triangle(const TriangleMesh& mesh, uint32_t triangle, const SweptSphere& sphere,
                            double& t);

}  // namespace haptic
