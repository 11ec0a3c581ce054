// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "sim/motion/motion.h"

namespace haptic {
namespace {

ScriptedState nod_at(const ObjectConfig& object, double phase, double phase_rate) {
  ScriptedState state{object.X_WO, {}};
  state.X_WO.p.z += 1e-3 * (1 - std::cos(phase));
  state.V_WO.v.z = 1e-3 * std::sin(phase) * phase_rate;
  return state;
}

double nod_phase(const ObjectConfig& object, const Pose& X_WO, const Twist&) {
  return std::acos(1 - 1e3 * (X_WO.p.z - object.X_WO.p.z));
}

}  // namespace

extern const Motion nod{nod_at, nod_phase};

}  // namespace haptic
