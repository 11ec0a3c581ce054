// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "proto/math/project_point.h"
#include "servo/solve/carried_contacts.h"

namespace haptic {

/// The part of space around the verified proxy that a complete set of contacts proves free for a
/// point: the free side of all of its planes, each in full, however far along it. A solver lets a
/// point past the extent of a plane, since a surface may end there; that something else begins
/// there is known only when contact has come to that place. The region is convex: with its two ends
/// a way lies in it. Planes of moving objects bound nothing here: where a point is in front of one
/// says nothing of where it will be.
struct FreeRegion {
  std::array<HalfSpace, kMaxContacts> half_spaces;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
};

/// The region of the set's contacts, offset by the radius of the proxy [m].
FreeRegion free_region(const ContactSet& set, const TickScene& scene, double radius);

/// True if a place is in the region, to rounding.
bool holds(const FreeRegion& region, const Vec3& p_W);

/// The place of the region nearest to p_W; from a place of the region the way there is no longer
/// than the way to p_W, since a projection onto a convex set does not expand.
Vec3 brought_into(const FreeRegion& region, const Vec3& p_W);

}  // namespace haptic
