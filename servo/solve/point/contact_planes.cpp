// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/contact_planes.h"

#include <algorithm>
#include <limits>

#include "proto/math/assert.h"
#include "servo/solve/point/rim_weight.h"

namespace haptic {
namespace {

double sideways(const ContactPlane& plane, const Vec3& x_W) {
  const Vec3 along_W = x_W - plane.point_W;
  return norm(along_W - dot(plane.full.normal, along_W) * plane.full.normal);
}

}  // namespace

bool carry_planes(const ContactSet& contacts, const std::array<Pose, kMaxObjects>& X_WO,
                  double radius, ContactPlanes& carried) {
  HAPTIC_ASSERT(radius >= 0);
  carried.size = std::min<size_t>(contacts.n_contacts, kMaxContacts);
  for (size_t i = 0; i < carried.size; ++i) {
    const Contact& c = contacts.contacts[i];
    if (c.object >= kMaxObjects) return false;
    const Vec3 normal_W = rotate(X_WO[c.object].q, c.normal_O);
    const Vec3 point_W = X_WO[c.object] * c.object_point_O;
    const HalfSpace full{normal_W, dot(normal_W, point_W) + radius};
    carried.planes[i] = {full, point_W, c.extent, 1, c.object};
    const bool finite = is_finite(normal_W) && is_finite(point_W) && std::isfinite(c.extent) &&
                        std::isfinite(full.offset);
    if (!finite) return false;
  }
  return true;
}

double extent_weight(const ContactPlane& plane, std::span<const Vec3> places_W) {
  HAPTIC_ASSERT(!places_W.empty());
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& place_W : places_W) nearest = std::min(nearest, sideways(plane, place_W));
  return rim_weight(nearest, plane.extent);
}

HalfSpace relaxed(const ContactPlane& plane, const Vec3& tool_W) {
  HAPTIC_ASSERT(plane.weight >= 0 && plane.weight <= 1);
  HalfSpace half_space = plane.full;
  const double depth = half_space.offset - dot(half_space.normal, tool_W);
  if (depth > 0 && plane.weight < 1) half_space.offset -= (1 - plane.weight) * depth;
  return half_space;
}

}  // namespace haptic
