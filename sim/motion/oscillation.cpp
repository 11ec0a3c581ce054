// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/motion/motion.h"

namespace haptic {
namespace {

Vec3 axis_in_world(const ObjectConfig& object) {
  return rotate(object.X_WO.q, normalized(object.motion.axis_O));
}

ScriptedState oscillation_at(const ObjectConfig& object, double phase, double phase_rate) {
  const double amplitude = object.motion.amplitude;
  const Vec3 axis_W = axis_in_world(object);
  ScriptedState state{object.X_WO, {}};
  state.X_WO.p += amplitude * std::sin(phase) * axis_W;
  state.V_WO.v = amplitude * std::cos(phase) * phase_rate * axis_W;
  return state;
}

double oscillation_phase(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO) {
  const MotionConfig& motion = object.motion;
  if (motion.amplitude == 0) return 0;
  const Vec3 axis_W = axis_in_world(object);
  const double sine = dot(X_WO.p - object.X_WO.p, axis_W) / motion.amplitude;
  const double phase = std::asin(std::clamp(sine, -1.0, 1.0));
  // asin gives the position whatever the twist's scale; the twist selects the branch
  const double direction = dot(V_WO.v, axis_W) * motion.amplitude * motion.frequency;
  return direction < 0 ? std::numbers::pi - phase : phase;
}

}  // namespace

/// p = p₀ + amplitude·sin(phase)·axis.
extern const Motion oscillation{oscillation_at, oscillation_phase};

}  // namespace haptic
