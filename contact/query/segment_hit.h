// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh_shape.h"

namespace haptic {

struct SegmentHit {
  bool hit = false;
  double t = 1;  // fraction of the way from → to, in [0, 1]
  uint32_t triangle = 0;
};

struct SegmentWitness {
  uint32_t triangle = kNoFace;
};

/// First triangle that the segment from → to (both in O) enters through its front side
/// (n·(to−from) < 0). Each vertex is projected along the segment with one rounding that all its
/// triangles share; on these points the edge volumes have exact signs and are exactly
/// antisymmetric, so no segment slips between two triangles that share an edge or a vertex (after
/// Woop, Benthin, Wald 2013, with the sign decided by the remainders where theirs is zero). A
/// zero-length segment hits nothing. Ties go to the lower triangle index. Line–OBB test of
/// H-Collide (Gregory, Lin, Gottschalk, Taylor 2000), padded for rounding.
SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O,
                     SegmentWitness& witness);
SegmentHit first_hit_by_tree(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

/// Segment against one triangle; the same arithmetic as first_hit. t is meaningful where true.
bool segment_enters_triangle(const Vec3& from_O, const Vec3& to_O, const Vec3& a, const Vec3& b,
                             const Vec3& c, double& t);

/// Whether the segment meets the box; in floats, and a segment that passes it by less than
/// 1e-5 of the largest coordinate may count as meeting it.
bool segment_meets_box(const Vec3& from_O, const Vec3& to_O, const CompactObb& box);

}  // namespace haptic
