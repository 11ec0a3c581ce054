// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "sim/bullet/bullet.h"

namespace haptic {

/// Rows for Bullet's solver, written anew for each step. Bullet's own joints have no row for an
/// implicit spring or a table, and report one impulse for all their rows; a joint of ours is a
/// constraint of its locks, and one of a single row for its friction and for its end stop each.
class RowConstraint : public btTypedConstraint {
 public:
  /// row_a · V_a + row_b · V_b = speed, by an impulse between the bounds.
  struct Row {
    Twist a, b;
    double speed = 0;
    double lower = -SIMD_INFINITY, upper = SIMD_INFINITY;
  };

  RowConstraint(btRigidBody& a, btRigidBody& b) : btTypedConstraint(D6_CONSTRAINT_TYPE, a, b) {}

  std::array<Row, 6> rows;
  size_t n = 0;

  void getInfo1(btConstraintInfo1* info) override {
    info->m_numConstraintRows = static_cast<int>(n);
    info->nub = 6 - static_cast<int>(n);
  }
  void getInfo2(btConstraintInfo2* info) override {
    for (size_t i = 0; i < n; ++i) {
      const Row& row = rows[i];
      const size_t at = i * static_cast<size_t>(info->rowskip);
      for (int k = 0; k < 3; ++k) {
        const size_t to = at + static_cast<size_t>(k);
        info->m_J1linearAxis[to] = row.a.v[k];
        info->m_J1angularAxis[to] = row.a.w[k];
        info->m_J2linearAxis[to] = row.b.v[k];
        info->m_J2angularAxis[to] = row.b.w[k];
      }
      info->m_constraintError[at] = row.speed;
      info->m_lowerLimit[at] = row.lower;
      info->m_upperLimit[at] = row.upper;
    }
  }
  // Bullet's way to parameters, of which this has none
  void setParam(int /*name*/, btScalar /*value*/, int /*axis*/) override {}
  btScalar getParam(int /*name*/, int /*axis*/) const override { return 0; }
};

}  // namespace haptic
