// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/sixmotors/kinematics.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {
namespace {

constexpr WoodenHapticsGeometry kCarrier;
constexpr double kMostRoll = 1.4;  // the stops of the wrist's middle axis, ± [rad]
// of the wrist: 3000 rad/s², by 5215 counts a radian. Its motors turn a bare handle of 1e-4 kg·m²
// no faster; an arm that throws turns it by 500
constexpr double kWristAcceleration = 1.6e-11;

bool find_handle(const JointAngles& q, Pose& X_BH) {
  const Quat turned = turn_about({0, 0, 1}, q[0]) * turn_about({0, 1, 0}, q[3] - q[2]) *
                      turn_about({1, 0, 0}, q[4]) * turn_about({0, 0, 1}, q[5]);
  X_BH = {tip_position(kCarrier, q), normalized(turned)};
  return true;
}

bool find_angles(const Pose& X_BH, JointAngles& q) {
  JointAngles found{};
  if (!solve_tip(kCarrier, X_BH.p, found)) return false;
  // what is left of the orientation, R(y, ψ) R(x, roll) R(z, yaw), by its entries
  const Mat3 rest = to_matrix(turn_about({0, 0, 1}, -found[0]) * X_BH.q);
  found[3] = std::atan2(rest.row[0].z, rest.row[2].z) + found[2];
  found[4] = std::asin(std::fmin(std::fmax(-rest.row[1].z, -1), 1));
  found[5] = std::atan2(rest.row[1].x, rest.row[1].y);
  if (!(std::fabs(found[4]) <= kMostRoll)) return false;
  q = found;
  return true;
}

bool handle_jacobian(const JointAngles& q, const Pose&, HandleJacobian& J) {
  const Mat3 tip = tip_jacobian(kCarrier, q);
  const Quat azimuth = turn_about({0, 0, 1}, q[0]);
  const Quat pitched = azimuth * turn_about({0, 1, 0}, q[3] - q[2]);
  const Vec3 level = rotate(azimuth, {0, 1, 0});
  J = {{{tip.column(0), {0, 0, 1}},
        {tip.column(1), {}},  // a parallel linkage: the upper arm leaves the forearm's direction
        {tip.column(2), -level},
        {{}, level},
        {{}, rotate(pitched, {1, 0, 0})},
        {{}, rotate(pitched * turn_about({1, 0, 0}, q[4]), {0, 0, 1})}}};
  return true;
}

}  // namespace

const Arm& six_motors_arm() {
  static const Arm kArm = [] {
    constexpr DrivenBody kWrist[] = {{8, 1, 1, 8192}, {8, -1, -1}, {8, 1, 1}};
    Arm arm = woodenhaptics_arm();
    arm.name = "device with six motors";
    arm.model = 6;
    arm.motors = arm.encoders = 6;
    arm.buttons = 0;
    arm.max_torque = 0.3;
    for (size_t i = 0; i < 3; ++i) {
      arm.axes[3 + i] = axis_of(kWrist[i], 4096, 0.0138);
      arm.axes[3 + i].most_acceleration = kWristAcceleration;
    }
    arm.find = find_handle;
    arm.jacobian = handle_jacobian;
    arm.solve = find_angles;
    return arm;
  }();
  return kArm;
}

std::unique_ptr<Device> open_six_motors(const DeviceConfig& config, FileDescriptor node) {
  return open_motor_device(six_motors_arm(), config, std::move(node));
}

}  // namespace haptic
