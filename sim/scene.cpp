// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "proto/math/assert.h"

namespace haptic {

ScriptedState scripted_state(const ObjectConfig& object, double phase, double phase_rate) {
  HAPTIC_ASSERT(is_unit(object.X_WO.q));
  const MotionConfig& motion = object.motion;
  const Vec3 axis_O = normalized(motion.axis_O);
  const Vec3 axis_W = rotate(object.X_WO.q, axis_O);
  ScriptedState state{object.X_WO, {}};
  switch (motion.kind) {
    case MotionKind::kStatic:
      break;
    case MotionKind::kOscillate:
      state.X_WO.p += motion.amplitude * std::sin(phase) * axis_W;
      state.V_WO.v = motion.amplitude * std::cos(phase) * phase_rate * axis_W;
      break;
    case MotionKind::kSpin:
      state.X_WO.q = normalized(object.X_WO.q * from_rotation_vector(phase * axis_O));
      if (norm_squared(axis_O) > 0) state.V_WO.w = phase_rate * axis_W;
      break;
  }
  return state;
}

double phase_of(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO) {
  HAPTIC_ASSERT(is_unit(object.X_WO.q));
  const MotionConfig& motion = object.motion;
  const Vec3 axis_O = normalized(motion.axis_O);
  switch (motion.kind) {
    case MotionKind::kStatic:
      return 0;
    case MotionKind::kOscillate: {
      if (motion.amplitude == 0) return 0;
      const Vec3 axis_W = rotate(object.X_WO.q, axis_O);
      const double sine = dot(X_WO.p - object.X_WO.p, axis_W) / motion.amplitude;
      const double phase = std::asin(std::clamp(sine, -1.0, 1.0));
      // asin gives the position whatever the twist's scale; the twist selects the branch
      const double direction = dot(V_WO.v, axis_W) * motion.amplitude * phase_speed(motion);
      return direction < 0 ? std::numbers::pi - phase : phase;
    }
    case MotionKind::kSpin:
      return dot(to_rotation_vector(conjugate(object.X_WO.q) * X_WO.q), axis_O);
  }
  return 0;
}

double phase_speed(const MotionConfig& motion) {
  return motion.kind == MotionKind::kStatic ? 0 : 2 * std::numbers::pi * motion.frequency;
}

}  // namespace haptic
