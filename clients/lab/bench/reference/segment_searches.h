// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/segment_hit.h"

namespace haptic {

/// The other columns of the table of H-Collide (Gregory, Lin, Gottschalk, Taylor 2000). Each
/// answers as first_hit does.

/// Every triangle of every cell along the segment; the tree where the cells do not reach.
SegmentHit first_hit_by_grid(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

/// The OBB tree from its root.
SegmentHit first_hit_by_tree(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

/// Descends the tree by bounding spheres and does not stop at a hit.
SegmentHit first_hit_naive(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O);

}  // namespace haptic
