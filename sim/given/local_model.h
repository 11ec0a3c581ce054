// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/motion_metric.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Where an object is by its model, and how it moves; both in W.
struct ModelState {
  Pose X_WO;
  Twist V_WO;
};

/// Largest angular frequency and damping rate of a model's own motion [rad/s, 1/s]: a step of the
/// model is then an eighth of its time, or less.
inline constexpr double kFastestModel = 1000;

/// Steps of the model in dt [s].
int steps_of_model(double dt);

/// Acceleration of the origin by all but hands, in W: a − M⁻¹ [D (V − V_f) + K (X ⊖ X_f)], with
/// pose X_f, twist V_f and acceleration a of the client's frame.
Twist own_acceleration(const GivenMotion& said, const ModelState& at);

/// The model dt [s] ≥ 0 later, in steps of at most 0.125 ms: half of the way, the change of twist,
/// the other half (Störmer and Verlet; position Verlet). dt is at most kMostReplay.
void drift(const GivenMotion& said, ModelState& at, double dt);
inline constexpr double kMostReplay = 0.6;  // the longest hold and a fade [s]

/// An impulse at the origin: V grows by M⁻¹ J. `late_W` is the integral [N·s²] of the impulse over
/// the time that it was given before now, which moves the pose by M⁻¹ S; negative: it comes later.
void push(const GivenMotion& said, ModelState& at, const Wrench& impulse_W, const Wrench& late_W);

/// The way from a state to another, and the difference of their twists.
struct StateGap {
  Twist way;
  Twist velocity;
};
StateGap gap_between(const ModelState& from, const ModelState& to);
ModelState moved(const ModelState& from, double share, const StateGap& gap);

}  // namespace haptic
