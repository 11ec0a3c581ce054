// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bullet/swinging_body.h"

#include "proto/math/assert.h"
#include "sim/bullet/body_state.h"

namespace haptic {
namespace {

// a change of a twist that is rounding [m/s], [rad/s]
constexpr double kSame = 1e-12;

}  // namespace

SwingingBody::SwingingBody(btRigidBody& body, const Vec3& arm_C, const Vec3& gravity_W)
    : body_(body),
      pivot_(build_pivot(body.getMass(), from_bullet(body.getLocalInertia()), arm_C)),
      gravity_W_(gravity_W) {}

/// Of a twist the angular momentum about the point, which the point cannot change.
Vec3 SwingingBody::about_point(const Twist& V_W, const Quat& q_WC) const {
  const Twist p = momentum_of(body_, V_W);
  return p.w + cross(rotate(q_WC, pivot_.arm_C), p.v);
}

Pivoting SwingingBody::now() const {
  const Quat q_WC = pose_of(body_).q;
  return {q_WC, about_point(twist_of(body_), q_WC)};
}

void SwingingBody::hang(const Vec3& point_W, const Quat& q_WC, const Vec3& spin_W) {
  const Vec3 arm_W = rotate(q_WC, pivot_.arm_C);
  body_.setCenterOfMassTransform(to_bullet(Pose{point_W + arm_W, q_WC}));
  set_twist(body_, {cross(spin_W, arm_W), spin_W});
}

void SwingingBody::before(double dt) {
  HAPTIC_ASSERT(dt > 0);
  const Pivoting start = now();
  if (is_free_) {
    const std::optional<Pivoting> next = swung(pivot_, start, gravity_W_, dt);
    is_free_ = next.has_value();
    if (next) next_ = *next;
  }
  body_.setGravity(to_bullet(is_free_ ? Vec3{} : gravity_W_));
  body_.setFlags(is_free_ ? 0 : BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  if (!is_free_) return;
  const Vec3 turn_W = to_rotation_vector(next_.q_WC * conjugate(start.q_WC));
  const Quat middle = from_rotation_vector(0.5 * turn_W) * start.q_WC;
  const Vec3 spin = 1 / dt * turn_W;
  mean_ = {cross(spin, rotate(middle, pivot_.arm_C)), spin};
  set_twist(body_, mean_);
}

void SwingingBody::after(const Vec3& point_W, bool is_touched) {
  if (is_free_) {
    const Twist got = twist_of(body_);
    const Twist hit{got.v - mean_.v, got.w - mean_.w};
    if (norm(hit.v) > kSame || norm(hit.w) > kSame) {
      is_touched = true;
      next_.momentum_W += about_point(hit, next_.q_WC);
    }
    hang(point_W, next_.q_WC, spin_of(pivot_, next_));
  }
  is_free_ = !is_touched;
}

void SwingingBody::shift(const Vec3& point_W, const Twist& displacement_W) {
  const Pivoting at = now();
  const Vec3 turn_W = spin_of(pivot_, {at.q_WC, about_point(displacement_W, at.q_WC)});
  hang(point_W, normalized(from_rotation_vector(turn_W) * at.q_WC), spin_of(pivot_, at));
}

}  // namespace haptic
