// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/box/obb_overlap.h"
#include "contact/query/proximity/pair_batch.h"

namespace haptic {

/// All pairs of triangles of two meshes at a distance of at most the band [m], with B at X_AB in A:
/// descends both trees at once, the larger box opened first. Writes at most out.size() pairs, in
/// tree order, and returns how many there are. None for a pose or band that is not finite, or a
/// band below 0.
size_t near_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
                  std::span<NearPair> out);

/// Returns true if there is any near pair; stops at the first.
bool any_near_pair(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                   double band);

}  // namespace haptic
