// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "proto/wire/per_object.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A contact carried to the pose of its object at this tick.
struct CarriedContact {
  Vec3 tool_point_T;  // on the tool
  Vec3 point_W;       // on the object
  Vec3 normal_W;      // unit, from object to tool
  Vec3 shading_W;     // normal that is felt; the same where nothing is shaded
  Vec3 velocity_W;    // of the object at that point
  double extent = 0;  // radius along the plane within which it stands for the surface; 0: any [m]
  double curvature = 0;  // by which the surface falls away from the plane; 0: flat [1/m]
  double stiffness = 0;  // 0: the session's [N/m]
  double given = 1;      // share of the set's weight that it has, by the age of what found it
  double weight = 1;     // share that is felt of its depth, by age and extent
  uint32_t object = 0;   // the body that it belongs to (TickScene)
};

/// Contacts at this tick, of one kind.
template <class Kind>
struct ContactsNow {
  std::array<Kind, kMaxContacts> contacts;
  size_t size = 0;
  bool finite = true;  // false: a contact or the pose of its object was not, and there are none

  std::span<Kind> view() { return {contacts.data(), size}; }
  std::span<const Kind> view() const { return {contacts.data(), size}; }
};
using CarriedContacts = ContactsNow<CarriedContact>;

/// A placed body that there is not: the world.
inline constexpr uint32_t kNoBody = kMostPlaced;

/// The planes of a client on an object.
struct PlacedSurface {
  uint32_t object = 0;   // kNoObject: in W
  uint32_t client = 0;   // index in the session file
  double share = 1;      // of their weight that the client's bank lets through
  bool is_used = false;  // the set has some
};
using PlacedSurfaces = UpTo<PlacedSurface, kMostSurfaces>;

/// The objects at this tick, and how much of the contacts is felt.
struct TickScene {
  PerObject<Pose> X_WO;
  PerObject<Twist> V_WO;
  double weight = 1;            // of the contacts, by their age
  uint32_t held = kMaxObjects;  // by the tool (guide rows); kMaxObjects: none
  double held_share = 1;        // of its weight that is left to its soft contacts
  // behind the objects in X_WO and V_WO: the planes of a client on an object are a surface of their
  // own, so that what it pushes is known of each client
  PlacedSurfaces surfaces;

  size_t n_objects() const { return X_WO.size() - surfaces.size(); }
  /// The object that a placed body is, or that a surface is on; kNoObject: the world.
  uint32_t object_of(uint32_t body) const {
    const size_t n = n_objects();
    return body >= n && body < X_WO.size() ? surfaces[body - n].object : body;
  }
  /// The placed body that a contact belongs to; beyond all where there is none.
  uint32_t body_of(const Contact& contact) const;
  /// Places the surfaces of a set's contacts, as many as there is room for. `kept` are those of the
  /// last tick: each keeps its place as long as it is used, since solvers know bodies by it.
  void place_surfaces(const ContactSet& set, PlacedSurfaces& kept);

  /// The pose of an object; that of the world where there is none of that number.
  Pose pose_of(uint32_t object) const { return object < X_WO.size() ? X_WO[object] : Pose{}; }
  /// By the age of the set and of what found the contact.
  double aged_weight(const CarriedContact& contact) const { return weight * contact.given; }
  double soft_weight(uint32_t object) const {
    return object == held ? weight * held_share : weight;
  }
};

/// Moves each contact of a set along with its object, whatever its weight.
CarriedContacts carry_contacts(const ContactSet& set, const TickScene& scene);

/// How far a surface has fallen away from its tangent plane, and how steeply, at a distance along
/// it: ½ κ s², κ s up to a slope of ½, where the second order ends; straight on from there.
struct Fall {
  double depth = 0;  // [m]
  double slope = 0;
  double bend = 0;  // derivative of the slope [1/m]
};
Fall fall_at(double curvature, double along);

/// The contact's weight, by the age of its set and the distance from its point along its plane to
/// the nearest of the places: w = age · clamp(1 − (along − extent)/(extent/10), 0, 1). Nothing is
/// felt past an edge, however old the set.
double weight_at(const CarriedContact& contact, double age_weight, std::span<const Vec3> places_W);

/// Distance from the contact's point along its plane to a place [m].
double distance_along(const CarriedContact& contact, const Vec3& place_W);

}  // namespace haptic
