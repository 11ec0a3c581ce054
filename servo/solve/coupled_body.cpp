// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/coupled_body.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kSmallAngle = 1e-4;   // below it the series is exact to rounding [rad]
constexpr double kLeastSpring = 1e-6;  // that a metric can be made of [N/m]
constexpr double kLeastTurn = 1e-3;    // of k_T radius², the same of rotation

/// Jr⁻¹(θ): derivative of log(E exp(δ)) by δ, E = exp(θ).
Mat3 inverse_right_jacobian(const Vec3& theta) {
  const double angle = norm(theta);
  const double half = 0.5 * angle;
  const double share =
      angle < kSmallAngle ? 1.0 / 12 : (1 - half / std::tan(half)) / (angle * angle);
  const Mat3 turn = skew(theta);
  return Mat3{} + 0.5 * turn + share * (turn * turn);
}

/// A spring whose force is bounded, with its derivative by the stretch.
struct Spring {
  Vec3 force;
  Mat3 by_stretch;
  double energy = 0;
};

Spring stretched(double stiffness, double most, const Vec3& stretch) {
  const double length = norm(stretch);
  if (!(most > 0) || stiffness * length <= most) {
    return {stiffness * stretch, stiffness * Mat3{}, 0.5 * stiffness * length * length};
  }
  const Vec3 u = stretch / length;
  const Mat3 along = from_columns(u.x * u, u.y * u, u.z * u);
  // beyond the bound only the direction changes; the energy grows linearly
  return {most * u, (most / length) * (Mat3{} + -1.0 * along),
          most * length - 0.5 * most * most / stiffness};
}

struct CouplingTerms {
  Spring linear, angular;
  Vec3 theta_W;
  Vec3 force_W, torque_W;  // on the proxy, dampers included
};

CouplingTerms terms_of(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy) {
  CouplingTerms t;
  // q conj(q) is the identity only up to rounding
  const bool as_one = hand.X_WT.q == proxy.X_WT.q;
  t.theta_W = as_one ? Vec3{} : to_rotation_vector(hand.X_WT.q * conjugate(proxy.X_WT.q));
  t.linear =
      stretched(coupling.translational_stiffness, coupling.max_force, hand.X_WT.p - proxy.X_WT.p);
  t.angular = stretched(coupling.rotational_stiffness, coupling.max_torque, t.theta_W);
  t.force_W = t.linear.force + coupling.translational_damping * (hand.V_WT.v - proxy.V_WT.v);
  t.torque_W = t.angular.force + coupling.rotational_damping * (hand.V_WT.w - proxy.V_WT.w);
  return t;
}

/// The terms about the centre of mass; the wrench without its Jacobian by motion.
struct CentralTerms : CouplingTerms {
  Mat3 r;  // [arm]×, from C to the origin of T
  BodyWrench wrench;
};

CentralTerms terms_about_centre(const Coupling& coupling, const ToolBody& body,
                                const ToolMotion& hand, const BodyMotion& proxy) {
  const Vec3 arm_W = -rotate(proxy.X_WC.q, body.centre_T);
  CentralTerms t{terms_of(coupling, hand, motion_of_tool(body, proxy)), skew(arm_W), {}};
  BodyWrench& sum = t.wrench;
  sum.F_W = {t.force_W, cross(arm_W, t.force_W) + t.torque_W};
  sum.energy = t.linear.energy + t.angular.energy;
  const double b = coupling.translational_damping;
  add_block(sum.by_twist, 0, 0, -b * Mat3{});
  add_block(sum.by_twist, 0, 3, b * t.r);
  add_block(sum.by_twist, 3, 0, -b * t.r);
  add_block(sum.by_twist, 3, 3, b * (t.r * t.r));
  add_block(sum.by_twist, 3, 3, -coupling.rotational_damping * Mat3{});
  return t;
}

}  // namespace

Vec3 coupling_force(const Coupling& coupling, const CouplingInput& input) {
  const Vec3 stretch_W = input.proxy_W - input.tool_W;
  const double length = norm(stretch_W);
  if (length == 0) return {};
  if (coupling.translational_damping == 0) return coupling.translational_stiffness * stretch_W;
  const Vec3 along_W = stretch_W / length;
  const double closing = dot(input.proxy_velocity_W - input.tool_velocity_W, along_W);
  const double force = coupling.translational_stiffness * length +
                       input.share * coupling.translational_damping * closing;
  return std::max(force, 0.0) * along_W;
}

Coupling with_least_springs(Coupling coupling, double radius) {
  double& k = coupling.translational_stiffness;
  k = std::max(k, kLeastSpring);
  coupling.rotational_stiffness =
      std::max(coupling.rotational_stiffness, kLeastTurn * k * (radius * radius));
  return coupling;
}

MotionMetric spring_metric(const Coupling& coupling) {
  return factor_metric(
      spring_matrix(coupling.translational_stiffness, coupling.rotational_stiffness));
}

BodyWrench coupling_wrench(const Coupling& coupling, const ToolBody& body, const ToolMotion& hand,
                           const BodyMotion& proxy) {
  const CentralTerms t = terms_about_centre(coupling, body, hand, proxy);
  const Mat3& r = t.r;
  const Mat3& k = t.linear.by_stretch;
  BodyWrench sum = t.wrench;
  // the tool's origin moves by δx − [r]× δθ, and its velocity turns with it
  const Mat3 force_by_angle = k * r + coupling.translational_damping * (skew(proxy.V_WC.w) * r);
  add_block(sum.by_motion, 0, 0, -1.0 * k);
  add_block(sum.by_motion, 0, 3, force_by_angle);
  add_block(sum.by_motion, 3, 0, -1.0 * (r * k));
  add_block(sum.by_motion, 3, 3, r * force_by_angle + skew(t.force_W) * r);
  add_block(sum.by_motion, 3, 3, -1.0 * (t.angular.by_stretch * inverse_right_jacobian(t.theta_W)));
  return sum;
}

BodyWrench symmetric_coupling_wrench(const Coupling& coupling, const ToolBody& body,
                                     const ToolMotion& hand, const BodyMotion& proxy) {
  const CentralTerms t = terms_about_centre(coupling, body, hand, proxy);
  const Mat3& r = t.r;
  const Mat3& k = t.linear.by_stretch;
  BodyWrench sum = t.wrench;
  add_block(sum.by_motion, 0, 0, -1.0 * k);
  add_block(sum.by_motion, 0, 3, k * r);
  add_block(sum.by_motion, 3, 0, -1.0 * (r * k));
  add_block(sum.by_motion, 3, 3, r * k * r);
  add_block(sum.by_motion, 3, 3, -1.0 * t.angular.by_stretch);
  return sum;
}

double coupling_energy(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy) {
  const CouplingTerms t = terms_of(coupling, hand, proxy);
  return t.linear.energy + t.angular.energy;
}

Wrench wrench_on_hand(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy) {
  const CouplingTerms t = terms_of(coupling, hand, proxy);
  return {-t.force_W, -t.torque_W};
}

}  // namespace haptic
