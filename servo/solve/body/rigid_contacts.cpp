// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/rigid_contacts.h"

#include <algorithm>
#include <limits>

#include "proto/math/assert.h"
#include "proto/wire/guide.h"

namespace haptic {
namespace {

constexpr double kStill = 1e-6;    // slower than this is rest [m/s]
constexpr size_t kMostPlaces = 3;  // poses of a proxy, and the hand's

/// The pose of the query, moved with the object since.
Pose carried_pose(const ContactSet& set, const BodyTick& tick, uint32_t object) {
  const Pose &then = set.objects[object].X_WO, &now = tick.X_WO[object];
  if (now == then) return set.X_WG;
  const Pose X_WG = now * (inverse(then) * set.X_WG);
  return {X_WG.p, normalized(X_WG.q)};
}

RigidContact posed(const CarriedContact& carried, const Materials& materials, const BodyTick& tick,
                   const Slides& slides, const Pose& X_WG) {
  RigidContact contact{carried, rotate(X_WG.q, carried.tool_point_T), 0, 0, {}};
  contact.gap = dot(contact.normal_W, X_WG.p + contact.r_W - contact.point_W);
  const MaterialConfig& material = materials.of(tick.object_of(contact.object));
  const bool has_slid = slides[contact.object];
  contact.friction = has_slid ? material.friction_dynamic : material.friction_static;
  contact.V_W = object_twist(tick, contact.object, X_WG.p);
  return contact;
}

}  // namespace

Twist object_twist(const BodyTick& tick, uint32_t object, const Vec3& place_W) {
  if (object >= tick.X_WO.size()) return {};
  return twist_with(tick.V_WO[object], place_W - tick.X_WO[object].p);
}

RigidContacts carry_rigid_contacts(const Materials& materials, const BodyTick& tick,
                                   const Slides& slides) {
  HAPTIC_ASSERT(tick.contacts != nullptr);
  const ContactSet& set = *tick.contacts;
  RigidContacts out;
  out.X_WG = set.X_WG;
  const size_t n = set.contacts.size(), n_placed = std::min(set.objects.size(), tick.X_WO.size());
  if (n > 0 && set.contacts[0].giver == 0 && set.contacts[0].object < n_placed) {
    out.carrier = set.contacts[0].object;
    out.X_WG = carried_pose(set, tick, out.carrier);
  }
  out.finite = is_finite(out.X_WG) && is_finite(tick.hand.X_WT) && is_finite(tick.hand.V_WT);
  const CarriedContacts carried = carry_contacts(set, tick);
  out.finite = out.finite && carried.finite;
  for (size_t i = 0; i < carried.size && out.finite; ++i) {
    const RigidContact& c = out.contacts[i] =
        posed(carried.contacts[i], materials, tick, slides, out.X_WG);
    out.finite = is_finite(c.r_W) && std::isfinite(c.gap) && is_finite(c.V_W);
  }
  // contacts too old to be felt are checked all the same
  out.size = out.finite && tick.weight > 0 ? n : 0;
  return out;
}

bool follow_surfaces(const BodyTick& tick, const SurfacePlaces& places, RigidContacts& contacts) {
  HAPTIC_ASSERT(!places.proxies_W.empty() && !places.within_W.empty());
  HAPTIC_ASSERT(places.within_W.size() <= kMostPlaces);
  bool has_changed = false;
  size_t n = 0;
  for (size_t i = 0; i < contacts.size; ++i) {
    RigidContact c = contacts.contacts[i];
    if (c.curvature > 0) {
      double along = std::numeric_limits<double>::infinity();
      for (const Pose& X_WP : places.proxies_W) {
        along = std::min(along, distance_along(c, X_WP * c.tool_point_T));
      }
      c.gap += fall_at(c.curvature, along).depth;
      has_changed = true;
    }
    std::array<Vec3, kMostPlaces> points_W;
    for (size_t k = 0; k < places.within_W.size(); ++k) {
      points_W[k] = places.within_W[k] * c.tool_point_T;
    }
    const double weight =
        weight_at(c, tick.aged_weight(c), {points_W.data(), places.within_W.size()});
    has_changed |= weight != c.weight;
    c.weight = weight;
    if (c.weight > 0) contacts.contacts[n++] = c;
  }
  contacts.size = n;
  return has_changed;
}

MotionRow row_of(const RigidContact& contact, const Vec3& about_W) {
  return {{contact.normal_W, cross(contact.r_W - about_W, contact.normal_W)}, -contact.gap};
}

MotionRow eased(MotionRow row, const Twist& motion, double share) {
  HAPTIC_ASSERT(!(share < 0));
  const double violation = row.b - dot(row.J, motion);
  if (violation > 0 && share < 1) row.b -= (1 - share) * violation;
  return row;
}

bool is_sliding(const RigidContact& contact, const Vec3& velocity_W) {
  const Vec3& n = contact.normal_W;
  return norm(velocity_W - dot(n, velocity_W) * n) > kStill;
}

}  // namespace haptic
