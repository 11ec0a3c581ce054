// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "proto/math/mat3.h"
#include "proto/math/pose.h"

namespace haptic {

/// A rigid body that can only turn about a fixed point; constant.
struct PivotBody {
  double mass = 0;     // [kg]
  Vec3 arm_C;          // from the point to the centre of mass
  Mat3 per_inertia_C;  // inverse of the inertia about the point [1/(kg·m²)]
};

/// `moments` about the axes of C through the centre of mass [kg·m²].
PivotBody build_pivot(double mass, const Vec3& moments, const Vec3& arm_C);

/// Its orientation, and its angular momentum about the point [N·m·s].
struct Pivoting {
  Quat q_WC;
  Vec3 momentum_W;
};

/// Angular velocity of that [rad/s].
Vec3 spin_of(const PivotBody& body, const Pivoting& at);

/// A step of dt [s] under gravity [m/s²] that keeps the energy (Simo and Wong 1991, with the mean
/// lever): with w the spin in C, and cay(θ) the rotation about θ by 2 atan(|θ|/2),
///   q′ = q cay(dt (w + w′)/2),  L′ = L + dt (r + r′)/2 × m g,  w′ = I⁻¹ q′⁻¹ L′.
/// Since r′ − r is dt (w + w′)/2 × (r + r′)/2, gravity's work is the change of the kinetic energy.
/// Second order in w dt. Solved by Newton's method; nothing where it does not converge, which takes
/// turns of more than a radian in a step.
std::optional<Pivoting> swung(const PivotBody& body, const Pivoting& now, const Vec3& gravity_W,
                              double dt);

}  // namespace haptic
