// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/carried_contacts.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRim = 0.1;       // width of the fade at the extent, as a share of it
constexpr double kSteepest = 0.5;  // slope up to which the second order describes a surface

CarriedContact carried(const Contact& c, const TickScene& scene, uint32_t body) {
  const Pose& X_WO = scene.X_WO[body];
  CarriedContact contact;
  contact.tool_point_T = c.tool_point_T;
  contact.point_W = X_WO * c.object_point_O;
  contact.normal_W = rotate(X_WO.q, c.normal_O);
  const bool shaded = norm_squared(c.shading_normal_O) > 0 && c.shading_normal_O != c.normal_O;
  contact.shading_W = shaded ? rotate(X_WO.q, c.shading_normal_O) : contact.normal_W;
  contact.velocity_W = velocity_at(scene.V_WO[body], contact.point_W - X_WO.p);
  contact.extent = c.extent;
  contact.curvature = c.curvature;
  contact.stiffness = c.stiffness;
  contact.given = std::clamp(1 - c.reduction, 0.0, 1.0);
  const size_t n = scene.n_objects();
  if (body >= n) contact.given *= scene.surfaces[body - n].share;
  contact.weight = scene.aged_weight(contact);
  contact.object = body;
  return contact;
}

bool is_sound(const CarriedContact& c) {
  return is_finite(c.tool_point_T) && is_finite(c.point_W) && is_finite(c.normal_W) &&
         is_finite(c.shading_W) && is_finite(c.velocity_W) && std::isfinite(c.extent) &&
         std::isfinite(c.curvature) && std::isfinite(c.stiffness) && std::isfinite(c.given);
}

}  // namespace

uint32_t TickScene::body_of(const Contact& contact) const {
  if (contact.giver == 0) return contact.object < n_objects() ? contact.object : kNoBody;
  const auto found = std::ranges::find_if(surfaces, [&](const PlacedSurface& s) {
    return moved_by_client(s.client) == contact.giver && s.object == contact.object;
  });
  if (found == surfaces.end()) return kNoBody;
  return static_cast<uint32_t>(n_objects() + static_cast<size_t>(found - surfaces.begin()));
}

void TickScene::place_surfaces(const ContactSet& set, PlacedSurfaces& kept) {
  const size_t n = n_objects();
  std::array<bool, kMostSurfaces> was_used{};
  for (size_t s = 0; s < kept.size(); ++s) was_used[s] = std::exchange(kept[s].is_used, false);
  for (const Contact& c : set.contacts) {
    const uint32_t client = c.giver - moved_by_client(0);
    if (client >= kMostClients || !(c.object < n || c.object == kNoObject)) continue;
    const auto same = std::ranges::find_if(
        kept, [&](const PlacedSurface& s) { return s.client == client && s.object == c.object; });
    size_t place = static_cast<size_t>(same - kept.begin());
    // a place that has been free for a tick is nobody's any more
    for (size_t s = 0; place == kept.size() && s < kept.size(); ++s) {
      if (!kept[s].is_used && !was_used[s]) place = s;
    }
    if (place == kMostSurfaces) continue;
    if (place == kept.size()) kept.push_back({});
    kept[place] = {c.object, client, kept[place].share, true};
  }
  while (!kept.empty() && !kept.back().is_used) kept.pop_back();
  surfaces = kept;
  for (const PlacedSurface& s : surfaces) {
    X_WO.push_back(s.object < n ? X_WO[s.object] : Pose{});
    V_WO.push_back(s.object < n ? V_WO[s.object] : Twist{});
  }
}

CarriedContacts carry_contacts(const ContactSet& set, const TickScene& scene) {
  HAPTIC_ASSERT(scene.weight >= 0 && scene.weight <= 1);
  CarriedContacts out;
  const size_t n = set.contacts.size();
  for (size_t i = 0; i < n && out.finite; ++i) {
    const uint32_t body = scene.body_of(set.contacts[i]);
    out.finite = body < scene.X_WO.size();
    if (!out.finite) break;
    out.contacts[i] = carried(set.contacts[i], scene, body);
    out.finite = is_sound(out.contacts[i]);
  }
  out.size = out.finite ? n : 0;
  return out;
}

Fall fall_at(double curvature, double along) {
  if (!(curvature > 0)) return {};
  const double bends = std::min(along, kSteepest / curvature);
  const double slope = curvature * bends;
  return {slope * (along - 0.5 * bends), slope, along <= bends ? curvature : 0};
}

double distance_along(const CarriedContact& contact, const Vec3& place_W) {
  const Vec3 way_W = place_W - contact.point_W;
  return norm(way_W - dot(contact.normal_W, way_W) * contact.normal_W);
}

double weight_at(const CarriedContact& contact, double age_weight, std::span<const Vec3> places_W) {
  HAPTIC_ASSERT(!places_W.empty());
  if (!(contact.extent > 0)) return age_weight;
  double along = std::numeric_limits<double>::infinity();
  for (const Vec3& place_W : places_W) along = std::min(along, distance_along(contact, place_W));
  const double rim = kRim * contact.extent, beyond = along - contact.extent;
  if (beyond <= 0) return age_weight;
  return beyond < rim ? age_weight * (1 - beyond / rim) : 0;
}

}  // namespace haptic
