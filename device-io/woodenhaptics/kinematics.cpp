// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/kinematics.h"

#include <cmath>
#include <memory>
#include <utility>

#include "device-io/sensing/encoder_noise.h"
#include "device-io/woodenhaptics/motor_device.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kSingular = 1e-3;  // of the determinant at a right-angled elbow: nearly straight

/// Upper arm and forearm, each with x along it, y level, to the left of where the arm points.
Vec3 moment_of_links(const WoodenHapticsGeometry& g, const LinkMasses& links,
                     const JointAngles& q) {
  const Vec3 out{std::cos(q[0]), std::sin(q[0]), 0}, left{-out.y, out.x, 0}, up{0, 0, 1};
  const Vec3 upper = std::sin(q[1]) * out + std::cos(q[1]) * up;
  const Vec3 fore = std::sin(q[2]) * out - std::cos(q[2]) * up;
  const Vec3 shoulder = g.shoulder_height * up - g.origin;
  const Vec3 elbow = shoulder + g.upper_arm * upper;
  return links[0].mass * link_place(shoulder, upper, left, links[0].centre) +
         links[1].mass * link_place(elbow, fore, left, links[1].centre);
}

/// Distance of the tip from A's axis [m].
double reach(const WoodenHapticsGeometry& g, const JointAngles& q) {
  return g.upper_arm * std::sin(q[1]) + g.forearm * std::sin(q[2]);
}

}  // namespace

Vec3 tip_position(const WoodenHapticsGeometry& g, const JointAngles& q) {
  const double rho = reach(g, q);
  const Vec3 tip{std::cos(q[0]) * rho, std::sin(q[0]) * rho,
                 g.shoulder_height + g.upper_arm * std::cos(q[1]) - g.forearm * std::cos(q[2])};
  return tip - g.origin;
}

bool solve_tip(const WoodenHapticsGeometry& g, const Vec3& p_B, JointAngles& q) {
  HAPTIC_ASSERT(g.upper_arm > 0 && g.forearm > 0);
  const Vec3 tip = p_B + g.origin;
  const double rho = std::hypot(tip.x, tip.y);
  const double height = tip.z - g.shoulder_height;
  const double distance = std::hypot(rho, height);
  // triangle of shoulder, elbow and tip: its angles at elbow and shoulder
  const double b = g.upper_arm, c = g.forearm;
  const double cos_elbow = (b * b + c * c - distance * distance) / (2 * b * c);
  const double cos_shoulder = (b * b + distance * distance - c * c) / (2 * b * distance);
  if (!(std::fabs(cos_elbow) < 1 && std::fabs(cos_shoulder) <= 1 && rho > 0)) return false;
  q[0] = std::atan2(tip.y, tip.x);
  q[1] = std::atan2(rho, height) - std::acos(cos_shoulder);
  q[2] = std::acos(cos_elbow) - q[1];
  return true;
}

Mat3 tip_jacobian(const WoodenHapticsGeometry& g, const JointAngles& q) {
  const double rho = reach(g, q), b = g.upper_arm, c = g.forearm;
  const double sin_a = std::sin(q[0]), cos_a = std::cos(q[0]);
  return from_columns({-sin_a * rho, cos_a * rho, 0},
                      {b * cos_a * std::cos(q[1]), b * sin_a * std::cos(q[1]), -b * std::sin(q[1])},
                      {c * cos_a * std::cos(q[2]), c * sin_a * std::cos(q[2]), c * std::sin(q[2])});
}

Axis axis_of(const DrivenBody& body, double counts_per_turn, double torque_constant) {
  return {.angle = angle_of_count(body.direction, counts_per_turn, body.ratio),
          .home = body.home,
          .torque = body.torque_direction * body.ratio * torque_constant,
          .most_acceleration = kTipAcceleration};
}

Arm serial_arm(const WoodenHapticsGeometry& g) {
  Arm arm;
  arm.max_force = 5;  // of the design [N]
  arm.least_volume = kSingular * g.upper_arm * g.forearm * g.forearm;
  arm.find = [g](const JointAngles& q, Pose& X_BH) {
    X_BH = {tip_position(g, q), {}};
    return true;
  };
  arm.jacobian = [g](const JointAngles& q, const Pose&, HandleJacobian& J) {
    const Mat3 tip = tip_jacobian(g, q);
    for (int i = 0; i < 3; ++i) J[static_cast<size_t>(i)].v = tip.column(i);
    return true;
  };
  arm.solve = [g](const Pose& X_BH, JointAngles& q) { return solve_tip(g, X_BH.p, q); };
  arm.links = [g](const LinkMasses& links, const JointAngles& q, const Pose&) {
    return moment_of_links(g, links, q);
  };
  return arm;
}

const Arm& woodenhaptics_arm() {
  static const Arm kArm = [] {
    constexpr DrivenBody kBodies[] = {{16, 1, 1}, {12, -1, -1}, {12, -1, -1, -6000}};
    Arm arm = serial_arm({});
    arm.name = "WoodenHaptics";
    arm.model = 3;
    arm.buttons = 1;  // of a firmware that reports one in the handle (protocol.h)
    for (size_t i = 0; i < 3; ++i) arm.axes[i] = axis_of(kBodies[i], 2000, 0.0259);
    return arm;
  }();
  return kArm;
}

std::unique_ptr<Device> open_woodenhaptics(const DeviceConfig& config, FileDescriptor node) {
  return open_motor_device(woodenhaptics_arm(), config, std::move(node));
}

}  // namespace haptic
