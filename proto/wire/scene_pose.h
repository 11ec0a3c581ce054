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

/// For how long an object goes on by its twist where its mover says nothing else, and the longest
/// that any may say [ns].
inline constexpr int64_t kExtrapolationNs = 20'000'000, kMostExtrapolationNs = 100'000'000;

constexpr double seconds_of(int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

/// For how long this object goes on [s].
inline double extrapolation_of(const SceneObject& object) {
  return seconds_of(std::clamp<int64_t>(object.extrapolation_ns, 0, kMostExtrapolationNs));
}

/// True if a body has gone so far from its place at the start that sim moves it no more.
inline bool is_out_of_reach(const Pose& X_WO, const Pose& X_start, double reach) {
  return norm(X_WO.p - X_start.p) > reach;
}

/// The pushes of one hand on the objects: the counters of its ServoFrame.
struct HandPush {
  uint32_t hand;
  int64_t t_ns;      // of the counters: the impulse stays as it is from here on
  int64_t since_ns;  // where they began
  std::span<const ObjectPush> pushes;
};

inline HandPush push_of(const ServoFrame& frame, uint32_t hand) {
  return {hand, frame.t_ns, frame.impulses_since_ns, frame.pushes};
}

/// How an object answers a push; null: it does not.
inline const ObjectResponse* response_of(const SceneFrame& scene, uint32_t object) {
  const uint32_t response = scene.objects[object].response;
  return response < scene.responses.size() ? &scene.responses[response] : nullptr;
}

/// How far sim has used a hand's counters for an object; null: it uses none.
inline const SeenPush* seen_of(const SceneFrame& scene, uint32_t object, uint32_t hand) {
  const uint64_t response = scene.objects[object].response;
  const uint64_t at = response * scene.n_hands + hand;
  const bool is_there = response_of(scene, object) != nullptr && hand < scene.n_hands;
  return is_there && at < scene.seen.size() ? &scene.seen[at] : nullptr;
}

/// Returns whether the scene lets a push move this object. The mobility is positive semidefinite,
/// so it is zero exactly where its diagonal is zero.
inline bool is_mobile(const SceneFrame& scene, uint32_t object) {
  const ObjectResponse* response = response_of(scene, object);
  if (response == nullptr) return false;
  for (size_t i = 0; i < 6; ++i) {
    if (response->mobility[7 * i] != 0) return true;
  }
  return false;
}

/// True if sim has used counters of a servo that began to count at since_ns.
inline bool is_counted(const SeenPush* seen, int64_t since_ns) {
  return seen != nullptr && seen->t_ns != 0 && seen->t_ns >= since_ns;
}

/// True if a push at t_ns still moves an object that is mobile: sim has used counters of this
/// servo, and the pose can still be extrapolated. What is pushed otherwise belongs into no counter.
inline bool takes_pushes(const SceneFrame& scene, uint32_t object, uint32_t hand, int64_t since_ns,
                         int64_t t_ns) {
  const SceneObject& at = scene.objects[object];
  return is_counted(seen_of(scene, object, hand), since_ns) &&
         seconds_of(t_ns - at.t_ns) <= extrapolation_of(at);
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
/// its extrapolation the integral stays as it was, which holds because the servo counts no push any
/// more.
inline UnseenPush unseen_push(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                              const HandPush& push) {
  const SeenPush* seen = seen_of(scene, object, push.hand);
  const SceneObject& at = scene.objects[object];
  if (!is_counted(seen, push.since_ns) || !is_mobile(scene, object)) return {};
  if (at.response >= push.pushes.size()) return {};
  const ObjectPush& counted = push.pushes[at.response];
  const double age = seconds_of(t_ns - at.t_ns), most = extrapolation_of(at);
  const double frozen = age - std::clamp(age, -most, most);
  UnseenPush unseen;
  unseen.impulse_W = counted.impulse_W + -seen->impulse_W;
  unseen.impulse_time_W = counted.impulse_time_W + -seen->impulse_time_W +
                          (seconds_of(t_ns - push.t_ns) - frozen) * unseen.impulse_W +
                          -seconds_of(push.t_ns - seen->t_ns) * seen->impulse_W;
  return unseen;
}

/// X_WO of one object at time t, by what the scene says alone: extrapolated by its twist, at most
/// extrapolation_of it either way (if its mover dies, it stands still).
inline Pose object_pose_at(const SceneFrame& scene, uint32_t object, int64_t t_ns) {
  const SceneObject& at = scene.objects[object];
  // a static object's pose stays bit-identical
  if (at.V_WO == Twist{}) return at.X_WO;
  const double most = extrapolation_of(at);
  return extrapolate(at.X_WO, at.V_WO, std::clamp(seconds_of(t_ns - at.t_ns), -most, most));
}

/// Velocity of the object's origin and its angular velocity, in W; zero where object_pose_at no
/// longer extrapolates.
inline Twist object_twist_at(const SceneFrame& scene, uint32_t object, int64_t t_ns) {
  const SceneObject& at = scene.objects[object];
  return std::fabs(seconds_of(t_ns - at.t_ns)) > extrapolation_of(at) ? Twist{} : at.V_WO;
}

/// Computes X_WO of one object at time t, with dt = t − t_object, at most extrapolation_of it
/// either way: V·dt + ½·a·dt² + M⁻¹ [S − S_seen − J_seen (t − t_seen)] from the scene's pose.
/// Servo, contact and whoever draws use this function, so they see an object in the same place. Of
/// an object that only follows its script it is object_pose_at of the scene alone.
inline Pose object_pose_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                           const UnseenPush& unseen) {
  const Pose X_WO = object_pose_at(scene, object, t_ns);
  const ObjectResponse* response = response_of(scene, object);
  if (response == nullptr) return X_WO;
  const SceneObject& at = scene.objects[object];
  const double most = extrapolation_of(at);
  const double dt = std::clamp(seconds_of(t_ns - at.t_ns), -most, most);
  const Twist travel = 0.5 * dt * dt * response->acceleration_W +
                       moved_by(response->mobility, unseen.impulse_time_W);
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
  const ObjectResponse* response = response_of(scene, object);
  const SceneObject& at = scene.objects[object];
  const double dt = seconds_of(t_ns - at.t_ns);
  if (response == nullptr || std::fabs(dt) > extrapolation_of(at)) return V_WO;
  return V_WO + dt * response->acceleration_W + moved_by(response->mobility, unseen.impulse_W);
}
inline Twist object_twist_at(const SceneFrame& scene, uint32_t object, int64_t t_ns,
                             const HandPush& push) {
  return object_twist_at(scene, object, t_ns, unseen_push(scene, object, t_ns, push));
}

/// Moves the objects of a scene by what another hand has pushed them with and sim has not used yet:
/// from then on they are where that hand has brought them, for who places them by its own pushes.
/// The unseen displacement grows linearly with time, so that a pose and a twist at the scene's
/// instant stand for it: X + M⁻¹ [S − S_seen − J_seen (t − t_seen)], V + M⁻¹ (J − J_seen).
inline void add_pushes_of_other(SceneFrame& scene, const HandPush& push) {
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectResponse* response = response_of(scene, i);
    if (response == nullptr) continue;
    SceneObject& object = scene.objects[i];
    const UnseenPush unseen = unseen_push(scene, i, object.t_ns, push);
    const Twist way = moved_by(response->mobility, unseen.impulse_time_W);
    if (way != Twist{}) object.X_WO = extrapolate(object.X_WO, way, 1);
    object.V_WO = object.V_WO + moved_by(response->mobility, unseen.impulse_W);
  }
}

/// Velocity in W of the point p_W fixed to the object.
inline Vec3 surface_velocity(const SceneFrame& scene, uint32_t object, const Pose& X_WO,
                             const Vec3& p_W, int64_t t_ns, const HandPush& push) {
  return velocity_at(object_twist_at(scene, object, t_ns, push), p_W - X_WO.p);
}

}  // namespace haptic
