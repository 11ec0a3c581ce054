// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/scene.h"

#include <array>
#include <numbers>

#include "proto/math/assert.h"

namespace haptic {

#define MOTION(id, name, motion, ...) extern const Motion motion;
#include "proto/config/motions.def"

namespace {

const Motion& motion_of(const ObjectConfig& object) {
  static constexpr std::array kAll{
#define MOTION(id, name, motion, ...) &motion,
#include "proto/config/motions.def"
  };
  HAPTIC_ASSERT(is_unit(object.X_WO.q));
  HAPTIC_ASSERT(static_cast<size_t>(object.motion.kind) < kAll.size());
  return *kAll[static_cast<size_t>(object.motion.kind)];
}

}  // namespace

ScriptedState scripted_state(const ObjectConfig& object, double phase, double phase_rate) {
  return motion_of(object).state_at(object, phase, phase_rate);
}

double phase_of(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO) {
  return motion_of(object).phase_of(object, X_WO, V_WO);
}

double phase_speed(const MotionConfig& motion) {
  return row_of(motion.kind).is_still ? 0 : 2 * std::numbers::pi * motion.frequency;
}

}  // namespace haptic
