// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/segment_entry.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// Result of the previous query, tested first (warm start). Only a hint: harmless if wrong, stale
/// or of another mesh.
struct SegmentWitness {
  uint32_t triangle = kNoFace;
  size_t slot = 0;  // grid cell in which the search ended
};

/// First triangle that the segment from → to (both in O) enters through its front side, n·(to−from)
/// < 0. Each vertex is projected along the segment with one rounding that all its triangles share;
/// there the edge functions have exact signs and are exactly antisymmetric, so no segment slips
/// between two triangles that share an edge or a vertex (after Woop, Benthin, Wald 2013, with the
/// sign taken from the remainders of the products where theirs is zero). A zero-length segment hits
/// nothing. Ties go to the lower triangle index.
///
/// H-Collide (Gregory, Lin, Gottschalk, Taylor 2000): the witness first, then the cells along the
/// segment with the boxes in each, up to the first hit; long segments and meshes without a grid use
/// the OBB tree. Boxes are tested in 8-bit integers, rounded conservatively.
SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O,
                     SegmentWitness& witness);

/// Without a witness; the same answer.
SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

/// Cells along a segment that are prefetched together.
inline constexpr size_t kAhead = 4;

/// Segment against one triangle; the same arithmetic as first_hit. t is valid if true.
bool segment_enters_triangle(const Vec3& from_O, const Vec3& to_O, const Vec3& a, const Vec3& b,
                             const Vec3& c, double& t);

/// Whether the segment meets the box; in float: a segment that misses it by less than 1e-5 of the
/// largest coordinate may count as meeting it.
bool segment_meets_box(const Vec3& from_O, const Vec3& to_O, const CompactObb& box);

}  // namespace haptic
