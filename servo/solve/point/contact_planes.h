// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "proto/math/project_point.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A contact carried to its object's pose at this tick.
struct ContactPlane {
  HalfSpace full;     // at full weight: where the tool's centre may be
  Vec3 point_W;       // on the object
  double extent = 0;  // of the contact along its plane [m]
  double weight = 1;  // remaining share of its depth, by age and extent
  uint32_t object = 0;
};

struct ContactPlanes {
  std::array<ContactPlane, kMaxContacts> planes;
  size_t size = 0;

  std::span<ContactPlane> view() { return {planes.data(), size}; }
};

/// The planes of a set in W, offset by the radius of the tool. False if a contact or the pose of
/// its object is not finite.
bool carry_planes(const ContactSet& contacts, const std::array<Pose, kMaxObjects>& X_WO,
                  double radius, ContactPlanes& carried);

/// Weight by distance from the contact point along the plane: 1 while any of the places is within
/// the extent, falling to 0 a tenth of the extent beyond it.
double extent_weight(const ContactPlane& plane, std::span<const Vec3> places_W);

/// The plane moved towards the tool, so that only `weight` of the depth is left.
HalfSpace relaxed(const ContactPlane& plane, const Vec3& tool_W);

}  // namespace haptic
