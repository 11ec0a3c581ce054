// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "proto/math/motion_metric.h"
#include "servo/solve/coupled_body.h"
#include "servo/solve/materials.h"

namespace haptic {

inline constexpr size_t kMaxCarrying = 6;  // rows that carry a motion, see least_constraint
// programs after which no round of friction begins: a jam is given up; the last one may take more
inline constexpr int kMaxFrictionSolves = 40;

/// A contact of a tool that never enters an object, the tool at X_WG. The weight is the share that
/// is left of what the hand violates it by.
struct RigidContact : CarriedContact {
  Vec3 r_W;        // the tool's point, from the tool's origin
  double gap = 0;  // along the normal; negative: they overlap [m]
  double friction = 0;
  Twist V_W;  // of the object, at the tool's origin
};

/// The contacts of a tick. `finite` is false also where the hand is not finite.
struct RigidContacts : ContactsNow<RigidContact> {
  Pose X_WG;                   // carried along with `carrier`
  uint32_t carrier = kNoBody;  // the object of the first contact
};

/// Tells of each placed body whether it slid in the last tick, where its ratio of sliding is in
/// force.
using Slides = std::array<bool, kMostPlaced>;

/// Twist of an object at a place; none of the world.
Twist object_twist(const BodyTick& tick, uint32_t object, const Vec3& place_W);

/// Carries a set to this tick: X_WG along with the object of the first contact, each contact with
/// its own. Where they moved apart the gap says so.
RigidContacts carry_rigid_contacts(const Materials& materials, const BodyTick& tick,
                                   const Slides& slides);

/// Poses near which the surfaces go on beside the contacts' points.
struct SurfacePlaces {
  std::span<const Pose> proxies_W;  // that the proxy may have: gaps grow as at the nearest
  std::span<const Pose> within_W;   // a contact holds while one of these is within its extent
};

/// Each gap grows by how far the surface has fallen away from its plane at the place of the tool's
/// point (fall_at), and each contact is eased by its extent (weight_at). Contacts of which nothing
/// is left are dropped. Normals do not turn: the force stays in the cone of what contact has said.
/// False if nothing has changed.
bool follow_surfaces(const BodyTick& tick, const SurfacePlaces& places, RigidContacts& contacts);

/// J·a ≥ −gap for motions from X_WG about a point displaced by `about_W` from the tool's origin.
MotionRow row_of(const RigidContact& contact, const Vec3& about_W);

/// The row relaxed until only `share` is left of what a motion violates it by. With the hand as
/// the motion, the force fades with the share.
MotionRow eased(MotionRow row, const Twist& motion, double share);

/// True if a contact slips whose point has this velocity relative to the object [m/s]: it moves
/// beside the normal.
bool is_sliding(const RigidContact& contact, const Vec3& velocity_W);

}  // namespace haptic
