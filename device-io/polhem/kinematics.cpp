// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/polhem/kinematics.h"

#include <cmath>
#include <memory>
#include <utility>

#include "device-io/polhem/linkage.h"
#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {
namespace {

constexpr PolhemLinkage kLinkage;
constexpr double kSingular = 0.01;  // of the Jacobian's determinant, by the lengths of the links
constexpr double kInLine = 1e-9;    // sine of E
constexpr double kCounts = 4096;    // of a turn of a motor, with quadrature
constexpr double kGimbalCounts = 1024;  // of a turn of an axis of the gimbal
// 100 m/s², where a count of C is 10 µm and more, one of A or B 25 µm
constexpr double kMostOfC = 100 / 10e-6 * 1e-18;
// 10,000 rad/s² of 163 counts: what a hand makes of the outer axes where they are nearly in line
constexpr double kMostOfGimbal = 1.6e-12;

/// A body that a capstan drives: `ratio` is its diameter by that of the capstan, `constant` the
/// torque of its motor [N·m/A].
Axis driven(double direction, double ratio, double constant, int32_t home) {
  return {angle_of_count(direction, kCounts, ratio), home, 0, direction * ratio * constant,
          kMostOfC};
}

Axis gimbal(double direction, int32_t home) {
  return {angle_of_count(direction, kGimbalCounts), home, 0, 0, kMostOfGimbal};
}

Vec3 driven_of(const JointAngles& q) {
  return {q[0], q[1], q[2]};
}

/// The orientation of the forearm in B.
Quat forearm_turn(const Vec3& driven) {
  return turn_about({0, 0, 1}, driven.x) * turn_about({0, 1, 0}, -forearm_angle(kLinkage, driven));
}

bool find_handle(const JointAngles& q, Pose& X_BH) {
  const Quat turned = forearm_turn(driven_of(q)) * turn_about({1, 0, 0}, q[3]) *
                      turn_about({0, 1, 0}, q[4]) * turn_about({1, 0, 0}, q[5]);
  X_BH = {handle_place(kLinkage, driven_of(q)), normalized(turned)};
  return true;
}

bool find_angles(const Pose& X_BH, JointAngles& q) {
  Vec3 driven;
  if (!solve_linkage(kLinkage, X_BH.p, driven)) return false;
  // what is left of the orientation, R(x, D) R(y, E) R(x, F), by its entries
  const Mat3 rest = to_matrix(conjugate(forearm_turn(driven)) * X_BH.q);
  const double sine = -std::hypot(rest.row[0].y, rest.row[0].z);
  double d = 0, f = std::atan2(-rest.row[1].z, rest.row[1].y);
  if (sine < -kInLine) {
    d = std::atan2(-rest.row[1].x, rest.row[2].x);
    f = std::atan2(-rest.row[0].y, -rest.row[0].z);
  }
  q = {driven.x, driven.y, driven.z, d, std::atan2(sine, rest.row[0].x), f};
  return true;
}

bool handle_jacobian(const JointAngles& q, const Pose&, HandleJacobian& J) {
  Mat3 place;
  // where it is singular the motors do nothing, which is not missed
  if (!linkage_jacobian(kLinkage, driven_of(q), place)) return true;
  for (int i = 0; i < 3; ++i) J[static_cast<size_t>(i)].v = place.column(i);
  return true;
}

}  // namespace

const Arm& polhem_arm() {
  static const Arm kArm{
      .name = "Polhem",
      .model = 1,
      .motors = 3,
      .encoders = 6,
      .max_force = 5,
      .least_volume = kSingular * kLinkage.upper_arm * kLinkage.forearm * kLinkage.forearm,
      // counts from where the firmware begins: folded, the handle in its rest
      .axes = {driven(1, 0.175 / 0.0288534, 0.0603, 8312),
               driven(-1, 0.1 / 0.0136981, 0.0538, -10366),
               driven(1, 0.1 / 0.0137281, 0.0538, 19764), gimbal(-1, 0), gimbal(-1, 30),
               gimbal(1, 0)},
      .find = find_handle,
      .jacobian = handle_jacobian,
      .solve = find_angles,
      .links = [](const LinkMasses& links, const JointAngles& q,
                  const Pose&) { return linkage_moment(kLinkage, links, driven_of(q)); },
  };
  return kArm;
}

std::unique_ptr<Device> open_polhem(const DeviceConfig& config, FileDescriptor node) {
  return open_motor_device(polhem_arm(), config, std::move(node));
}

}  // namespace haptic
