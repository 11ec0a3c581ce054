// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Moves V_B on by the backward difference of two poses `dt` [s] apart through one pole at
/// `cutoff` [Hz]: V += α (ΔX/dt − V), α = dt/(dt + 1/(2π cutoff)); of the orientation, the rotation
/// vector.
void low_pass_velocity(const Pose& before_B, const Pose& after_B, double dt, double cutoff,
                       Twist& V_B);

}  // namespace haptic
