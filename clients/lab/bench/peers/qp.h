// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "proto/math/motion_metric.h"

namespace haptic {

/// CGAL's exact quadratic program solver, on the problem of least_constraint.
Twist cgal_least_constraint(const Mat6& M, const Twist& a_u, std::span<const MotionRow> rows);

/// Bullet's Dantzig pivoting on f ≥ 0, A f + b ≥ 0, complementary; A is stored by rows. False if it
/// reports failure.
using DantzigPeer = std::function<bool(std::span<const double> A, std::span<const double> b,
                                       std::vector<double>& f)>;

/// Empty if built without Bullet.
DantzigPeer make_bullet_dantzig();

}  // namespace haptic
