// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/motion/motion.h"

namespace haptic {
namespace {

ScriptedState spin_at(const ObjectConfig& object, double phase, double phase_rate) {
  const Vec3 axis_O = normalized(object.motion.axis_O);
  ScriptedState state{object.X_WO, {}};
  state.X_WO.q = normalized(object.X_WO.q * from_rotation_vector(phase * axis_O));
  if (norm_squared(axis_O) > 0) state.V_WO.w = phase_rate * rotate(object.X_WO.q, axis_O);
  return state;
}

double spin_phase(const ObjectConfig& object, const Pose& X_WO, const Twist&) {
  return dot(to_rotation_vector(conjugate(object.X_WO.q) * X_WO.q),
             normalized(object.motion.axis_O));
}

}  // namespace

/// Turned by the phase about the axis through the object's origin.
extern const Motion spin{spin_at, spin_phase};

}  // namespace haptic
