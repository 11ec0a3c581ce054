// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/felt_step.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kLeastStiffness = 1e-6;  // that a metric can be made of [N/m], [N·m/rad]

Pose carrier_pose(uint32_t carrier, const std::array<Pose, kMaxObjects>& X_WO) {
  return carrier < kMaxObjects ? X_WO[carrier] : Pose{};
}

Wrench rotated(const Quat& q, const Wrench& F) {
  return {rotate(q, F.f), rotate(q, F.t)};
}

}  // namespace

Wrench limit_felt_step(FeltStep& state, const WantedForce& step,
                       const std::array<Pose, kMaxObjects>& X_WO) {
  HAPTIC_ASSERT(step.dt > 0);
  const double k_T = std::max(step.translational, kLeastStiffness);
  const double k_R = std::max(step.rotational, kLeastStiffness);
  Wrench F_W = step.F_W;
  if (state.started) {
    const Pose X_WC = carrier_pose(state.carrier, X_WO);
    const Wrench last_W = rotated(X_WC.q, state.F_C);
    const Twist hand = way_between(X_WC * state.X_CT, step.X_WT);
    const double most = k_T * spring_length(hand, k_T, k_R) + kMostForceRate * step.dt;
    const double size = spring_force(F_W + -last_W, k_T, k_R);
    if (size > most) F_W = last_W + most / size * (F_W + -last_W);
  }
  const Pose X_CW = inverse(carrier_pose(step.carrier, X_WO));
  state = {true, step.carrier, X_CW * step.X_WT, rotated(X_CW.q, F_W)};
  return F_W;
}

}  // namespace haptic
