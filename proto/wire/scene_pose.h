// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/wire.h"

namespace haptic {

inline constexpr double kMaxExtrapolation = 0.020;  // longest extrapolation of a scene pose [s]

/// X_WO of one object at time t: the scene's pose extrapolated by its twist, at most 20 ms either
/// way (if sim dies, the scene freezes). Servo and contact both use this function, so they see an
/// object in the same place.
inline Pose object_pose_at(const SceneFrame& scene, uint32_t object, int64_t t_ns) {
  HAPTIC_ASSERT(object < kMaxObjects);
  const Pose& X_WO = scene.X_WO[object];
  const Twist& V_WO = scene.V_WO[object];
  // a static object's pose stays bit-identical
  if (V_WO == Twist{}) return X_WO;
  const double dt = std::clamp(static_cast<double>(t_ns - scene.t_ns) * 1e-9, -kMaxExtrapolation,
                               kMaxExtrapolation);
  return extrapolate(X_WO, V_WO, dt);
}

/// Velocity of the object's origin and its angular velocity, in W; zero where object_pose_at no
/// longer extrapolates.
inline Twist object_twist_at(const SceneFrame& scene, uint32_t object, int64_t t_ns) {
  HAPTIC_ASSERT(object < kMaxObjects);
  const double dt = static_cast<double>(t_ns - scene.t_ns) * 1e-9;
  return std::fabs(dt) > kMaxExtrapolation ? Twist{} : scene.V_WO[object];
}

/// Velocity in W of the point p_W fixed to the object.
inline Vec3 surface_velocity(const SceneFrame& scene, uint32_t object, const Pose& X_WO,
                             const Vec3& p_W, int64_t t_ns) {
  return velocity_at(object_twist_at(scene, object, t_ns), p_W - X_WO.p);
}

}  // namespace haptic
