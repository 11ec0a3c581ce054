// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/hands.h"
#include "proto/wire/wire.h"

namespace haptic {

inline constexpr double kMaxExtrapolation = 0.020;  // longest extrapolation of a scene pose [s]

/// True if a body has gone so far from its place at the start that sim moves it no more.
inline bool is_out_of_reach(const Pose& X_WO, const Pose& X_start, double reach) {
  return norm(X_WO.p - X_start.p) > reach;
}

/// The pushes of one hand on the objects: the counters of its ServoFrame.
struct HandPush {
  uint32_t hand;
  int64_t t_ns;      // of the counters: the impulse stays as it is from here on
  int64_t since_ns;  // where they began
  std::span<const Wrench, kMaxObjects> impulse_W, impulse_time_W;
};

inline HandPush push_of(const ServoFrame& frame, uint32_t hand = kFirstHand) {
  HAPTIC_ASSERT(hand < kMostHands);
  return {hand, frame.t_ns, frame.impulses_since_ns, frame.object_impulse_W,
          frame.object_impulse_time_W};
}

/// Returns whether the scene lets a push move this object. The mobility is positive semidefinite,
/// so it is zero exactly where its diagonal is zero.
inline bool is_mobile(const SceneFrame& scene, uint32_t object) {
  HAPTIC_ASSERT(object < kMaxObjects);
  if (object >= scene.n_responses) return false;
  const std::array<double, 36>& mobility = scene.responses[object].mobility;
  for (size_t i = 0; i < 6; ++i) {
    if (mobility[7 * i] != 0) return true;
  }
  return false;
}

/// True if a push at t_ns still moves what is mobile: sim has used counters of this servo, and its
/// frame can still be extrapolated. What is pushed otherwise belongs into no counter.
inline bool takes_pushes(const SceneFrame& scene, uint32_t hand, int64_t since_ns, int64_t t_ns) {
  HAPTIC_ASSERT(hand < kMostHands);
  const int64_t seen_ns = scene.seen_t_ns[hand];
  return seen_ns != 0 && seen_ns >= since_ns &&
         static_cast<double>(t_ns - scene.t_ns) * 1e-9 <= kMaxExtrapolation;
}

/// Mobility times an impulse: the change of twist. Mobility times the integral of an impulse: the
/// displacement.
inline Twist moved_by(const std::array<double, 36>& mobility, const Wrench& J_W) {
  const std::array<double, 6> j{J_W.f.x, J_W.f.y, J_W.f.z, J_W.t.x, J_W.t.y, J_W.t.z};
  std::array<double, 6> d{};
  for (size_t row = 0; row < 6; ++row) {
    for (size_t column = 0; column < 6; ++column) d[row] += mobility[6 * row + column] * j[column];
  }
  return {{d[0], d[1], d[2]}, {d[3], d[4], d[5]}};
}

/// The part of a hand's push on an object that sim has not used yet.
struct UnseenPush {
  Wrench impulse_W;       // J − J_seen
  Wrench impulse_time_W;  // S − S_seen − J_seen (t − t_seen)
};

/// Computes what is unseen at t; nothing of an object that does not move when it is pushed. Beyond
/// 20 ms the integral stays as it was, which holds because the servo counts no push any more.
inline UnseenPush unseen_push(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                              const HandPush& push) {
  const int64_t seen_ns = scene.seen_t_ns[push.hand];
  if (seen_ns == 0 || seen_ns < push.since_ns || !is_mobile(scene, object)) return {};
  const SeenPush& seen = scene.responses[object].seen[push.hand];
  const auto seconds = [](int64_t ns) { return static_cast<double>(ns) * 1e-9; };
  const double age = seconds(t_ns - scene.t_ns);
  const double frozen = age - std::clamp(age, -kMaxExtrapolation, kMaxExtrapolation);
  UnseenPush unseen;
  unseen.impulse_W = push.impulse_W[object] + -seen.impulse_W;
  unseen.impulse_time_W = push.impulse_time_W[object] + -seen.impulse_time_W +
                          (seconds(t_ns - push.t_ns) - frozen) * unseen.impulse_W +
                          -seconds(push.t_ns - seen_ns) * seen.impulse_W;
  return unseen;
}

/// X_WO of one object at time t, by what the scene says alone: extrapolated by its twist, at most
/// 20 ms either way (if sim dies, the scene freezes).
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

/// Computes X_WO of one object at time t, with dt = t − t_scene, at most 20 ms either way:
/// V·dt + ½·a·dt² + M⁻¹ [S − S_seen − J_seen (t − t_seen)] from the scene's pose. Servo, contact
/// and whoever draws use this function, so they see an object in the same place. Of an object that
/// only follows its script it is object_pose_at of the scene alone.
inline Pose object_pose_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                           const UnseenPush& unseen) {
  const Pose X_WO = object_pose_at(scene, object, t_ns);
  if (object >= scene.n_responses) return X_WO;
  const ObjectResponse& response = scene.responses[object];
  const double dt = std::clamp(static_cast<double>(t_ns - scene.t_ns) * 1e-9, -kMaxExtrapolation,
                               kMaxExtrapolation);
  const Twist travel =
      0.5 * dt * dt * response.acceleration_W + moved_by(response.mobility, unseen.impulse_time_W);
  return travel == Twist{} ? X_WO : extrapolate(X_WO, travel, 1);
}
inline Pose object_pose_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                           const HandPush& push) {
  return object_pose_at(scene, object, t_ns, unseen_push(scene, object, t_ns, push));
}

/// Computes the velocity of the object's origin and its angular velocity, in W:
/// V + a·dt + M⁻¹ (J − J_seen); zero where object_pose_at no longer extrapolates.
inline Twist object_twist_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                             const UnseenPush& unseen) {
  const Twist V_WO = object_twist_at(scene, object, t_ns);
  const double dt = static_cast<double>(t_ns - scene.t_ns) * 1e-9;
  if (object >= scene.n_responses || std::fabs(dt) > kMaxExtrapolation) return V_WO;
  const ObjectResponse& response = scene.responses[object];
  return V_WO + dt * response.acceleration_W + moved_by(response.mobility, unseen.impulse_W);
}
inline Twist object_twist_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                             const HandPush& push) {
  return object_twist_at(scene, object, t_ns, unseen_push(scene, object, t_ns, push));
}

/// Velocity in W of the point p_W fixed to the object.
inline Vec3 surface_velocity(const SceneFrame& scene, uint32_t object, const Pose& X_WO,
                             const Vec3& p_W, int64_t t_ns, const HandPush& push) {
  return velocity_at(object_twist_at(scene, object, t_ns, push), p_W - X_WO.p);
}

}  // namespace haptic
