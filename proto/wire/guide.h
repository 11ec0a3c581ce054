// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/math/motion_metric.h"
#include "proto/wire/renderer.h"
#include "proto/wire/wire.h"

/// A guide row holds both ways: n·(tool point − object point) = 0. Contact makes such rows of what
/// the tool has grasped.
namespace haptic {

/// Time in which a grasp is let in [s]: its strength grows from 0 to 1, as a change of the coupling
/// does, so that a hand that has pulled already feels no step.
inline constexpr double kGraspTime = 0.200;

/// The pose that the contacts of a set are those of. A tool that may enter objects is its proxy.
inline const Pose& place_of(const ContactSet& set) {
  const bool is_soft = row_of(static_cast<Renderer>(set.renderer)).moves == Moves::kSoftBody;
  return is_soft ? set.X_WT : set.X_WG;
}

/// The twist of what an object carries, at this arm from its origin.
constexpr Twist twist_with(const Twist& V_WO, const Vec3& arm_W) {
  return {velocity_at(V_WO, arm_W), V_WO.w};
}

/// The tool on its way to where it is held: the share of the way that the grasp's strength allows.
/// What the hand has left of the way is the spring that it feels.
inline Pose drawn_towards(const Pose& X_WT, const Pose& X_WP, double share) {
  const Pose X = moved(X_WT, share * way_between(X_WT, X_WP));
  return {X.p, normalized(X.q)};
}
constexpr Twist drawn_towards(const Twist& V_WT, const Twist& V_WP, double share) {
  return V_WT + share * (V_WP - V_WT);
}

}  // namespace haptic
