// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "proto/math/mat3.h"
#include "proto/math/spatial.h"
#include "sim/bullet/constraint_row.h"

namespace haptic {

/// A body's resistance to motion.
struct BodyInertia {
  double mass = 0;  // [kg]; 0: it does not move
  Mat3 inertia_W;   // about the centre of mass [kg·m²]
};

/// Bodies that are looked at together for one that is pushed: itself, then what it touches, and so
/// on. What lies beyond counts as fixed.
inline constexpr size_t kMostNeighbours = 8;

/// Change of the twist of `object` per impulse on it, both at its centre of mass in W, where no row
/// lets anything move along it: the object's block of (M + κ AᵀA)⁻¹, with κ a million times the
/// heaviest mass, which holds what the rows hold to one in a million. Zero where they hold all.
/// `n_bodies` is how many bodies are looked at, at most kMostNeighbours: with 1 the others count as
/// fixed. `bodies` has one for each object of the rows.
Mat6 mobility_at_centre(std::span<const BodyInertia> bodies, std::span<const ConstraintRow> rows,
                        uint32_t object, size_t n_bodies);

/// The same map at a point with this arm from the centre of mass: T M Tᵀ.
Mat6 mobility_at(const Mat6& at_centre, const Vec3& arm_W);

}  // namespace haptic
