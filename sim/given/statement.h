// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/spatial.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Largest numbers that a client may state: speed and acceleration ten times those of a hand, the
/// mobility of the lightest body that a session file may have, and of one with a radius of 1 mm.
struct StatementLimits {
  double distance = 100;          // of a pose from the origin of W [m]
  double speed = 20;              // [m/s]
  double turning = 200;           // [rad/s]
  double acceleration = 1e4;      // [m/s², rad/s²]
  double mobility = 1e3;          // 1/mass: a gram [1/kg]
  double turning_mobility = 1e9;  // [1/(kg·m²)]
  double least_mobility = 1e-6;   // of what answers at all: 1000 t, or as much inertia
  double stiffness = 1e7;         // stiffer is a wall [N/m, N·m/rad]
  double damping = 1e5;           // [N·s/m, N·m·s/rad]
  double symmetry = 1e-6;         // of a matrix with a diagonal of ones
};

/// Why what a client says of an object cannot be used, by its numbers alone: not finite, beyond the
/// limits, a matrix that is not symmetric or not positive semidefinite, or a motion of its own that
/// is faster than kFastestModel (tr M⁻¹K and tr M⁻¹D bound the squares of its frequencies and its
/// rates). kNone: it can.
GiverRefusal refusal_of(const GivenMotion& said, const StatementLimits& limits = {});

/// The mass of what a mobility lets answer: its pseudo-inverse, which is zero where nothing
/// answers.
Mat6 mass_of_mobility(const std::array<double, 36>& mobility);

}  // namespace haptic
