// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "proto/math/motion_metric.h"

namespace haptic {

/// CGAL's exact quadratic program solver, on the problem of least_constraint.
Twist cgal_least_constraint(const Mat6& M, const Twist& a_u, std::span<const MotionRow> rows);

/// Bullet's Dantzig pivoting on f ≥ 0, A f + b ≥ 0, complementary.
class DantzigPeer {
 public:
  virtual ~DantzigPeer() = default;
  /// A is stored by rows. False if it reports failure.
  virtual bool solve(std::span<const double> A, std::span<const double> b,
                     std::vector<double>& f) = 0;
};

/// Null if built without Bullet.
std::unique_ptr<DantzigPeer> make_bullet_dantzig();

}  // namespace haptic
