// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/given/local_model.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kStep = 0.125 / kFastestModel;  // [s]

/// M x of a matrix in a record.
Wrench times(const std::array<double, 36>& matrix, const Twist& motion) {
  return Mat6{matrix} * motion;
}

}  // namespace

Twist own_acceleration(const GivenMotion& said, const ModelState& at) {
  const Wrench held = times(said.stiffness, way_between(said.X_WO, at.X_WO)) +
                      times(said.damping, at.V_WO - said.V_WO);
  return said.acceleration_W - moved_by(said.mobility, held);
}

int steps_of_model(double dt) {
  return static_cast<int>(std::ceil(dt / kStep));
}

void drift(const GivenMotion& said, ModelState& at, double dt) {
  HAPTIC_ASSERT(dt >= 0 && dt <= kMostReplay);
  const int n = steps_of_model(dt);
  const double h = n > 0 ? dt / n : 0;
  for (int i = 0; i < n; ++i) {
    at.X_WO = extrapolate(at.X_WO, at.V_WO, 0.5 * h);
    at.V_WO = at.V_WO + h * own_acceleration(said, at);
    at.X_WO = extrapolate(at.X_WO, at.V_WO, 0.5 * h);
  }
}

void push(const GivenMotion& said, ModelState& at, const Wrench& impulse_W, const Wrench& late_W) {
  at.V_WO = at.V_WO + moved_by(said.mobility, impulse_W);
  const Twist way = moved_by(said.mobility, late_W);
  if (way != Twist{}) at.X_WO = moved(at.X_WO, way);
}

StateGap gap_between(const ModelState& from, const ModelState& to) {
  return {way_between(from.X_WO, to.X_WO), to.V_WO - from.V_WO};
}

ModelState moved(const ModelState& from, double share, const StateGap& gap) {
  return {moved(from.X_WO, share * gap.way), from.V_WO + share * gap.velocity};
}

}  // namespace haptic
