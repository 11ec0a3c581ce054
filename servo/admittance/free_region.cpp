// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance/free_region.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRounding = 1e-12;  // of a solver that lies on a plane [m]

}  // namespace

FreeRegion free_region(const ContactSet& set, const TickScene& scene, double radius) {
  HAPTIC_ASSERT(radius >= 0);
  FreeRegion region;
  const CarriedContacts carried = carry_contacts(set, scene);
  for (size_t i = 0; i < carried.size; ++i) {
    const CarriedContact& c = carried.contacts[i];
    if (!(scene.V_WO[c.object] == Twist{})) continue;
    region.half_spaces[region.size++] = {c.normal_W, dot(c.normal_W, c.point_W) + radius};
  }
  return region;
}

bool holds(const FreeRegion& region, const Vec3& p_W) {
  const auto is_behind = [&p_W](const HalfSpace& h) {
    return dot(h.normal, p_W) < h.offset - kRounding;
  };
  return std::none_of(region.view().begin(), region.view().end(), is_behind);
}

Vec3 brought_into(const FreeRegion& region, const Vec3& p_W) {
  return project_onto_half_spaces(p_W, region.view()).x;
}

}  // namespace haptic
