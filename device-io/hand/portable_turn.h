// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/quat.h"

/// Rotations of exactly rounded operations only, so that a seed gives the same hand to the bit on
/// every machine: the last bit of libm's sin, cos and atan2 differs between them.
namespace haptic {

/// Sine and cosine by a Taylor series to x¹⁹, accurate to 3e-16.
double portable_sin(double x);
double portable_cos(double x);

/// exp: the rotation by |r| about r [rad].
Quat portable_turn(const Vec3& r);

/// log along the shorter arc: angle in [0, π] [rad]; accurate to 1e-15.
Vec3 portable_rotation_vector(const Quat& q);

/// The rotation by `turn` and the angular velocity that the derivative of this rotation vector
/// makes, w = J_l(turn) rate, both in the frame of the vectors.
Vec3 angular_velocity_of(const Vec3& turn, const Vec3& rate);

/// The inverse: derivative of the rotation vector `turn` at the angular velocity w,
///   J_l⁻¹ w = w − ½ turn×w + β turn×(turn×w),  β = (1 − φ cot φ)/|turn|², φ = |turn|/2.
Vec3 rotation_vector_rate(const Vec3& turn, const Vec3& w);

/// That β. |turn| at most π [rad].
double turn_curvature(const Vec3& turn);

}  // namespace haptic
