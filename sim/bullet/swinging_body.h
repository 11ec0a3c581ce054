// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/spatial.h"
#include "sim/bullet/bullet.h"
#include "sim/joint/pivot.h"

namespace haptic {

/// A body whose only joint is a ball at a point that never moves. While nothing touches it, it
/// swings by itself (swung); Bullet sees its mean twist alone, to find what it runs into. Bullet
/// holds such a body by an impulse along the lever of the step before: it loses energy, and slowly
/// gains some where it turns fast. What touches something is Bullet's, and what turns by more than
/// a radian in a step.
class SwingingBody {
 public:
  /// `arm_C`: from the point to the centre of mass, in the body's frame C.
  SwingingBody(btRigidBody& body, const Vec3& arm_C, const Vec3& gravity_W);

  bool is_free() const { return is_free_; }
  /// Before a step of Bullet; while it is free then, the joint needs no rows.
  void before(double dt);
  /// After it: contacts that Bullet has found give momentum about the point.
  void after(const Vec3& point_W, bool is_touched);
  /// Turns it by the displacement's share of momentum about the point.
  void shift(const Vec3& point_W, const Twist& displacement_W);

 private:
  Pivoting now() const;
  Vec3 about_point(const Twist& V_W, const Quat& q_WC) const;
  void hang(const Vec3& point_W, const Quat& q_WC, const Vec3& spin_W);

  btRigidBody& body_;
  PivotBody pivot_;
  Vec3 gravity_W_;
  Pivoting next_;  // of the step under way
  Twist mean_;     // over that step
  bool is_free_ = true;
};

}  // namespace haptic
