// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/owndevice/own_device_arm.h"

#include <memory>
#include <utility>

#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {
namespace {

constexpr double kMetre = 1e-6;        // a count of position; finer than any device's [m]
constexpr double kRadian = 1e-5;       // a count of the rotation vector [rad]
constexpr double kNewton = 5e-3;       // a number of the line; of force [N]
constexpr double kNewtonMetre = 1e-4;  // of torque [N·m]
constexpr double kThousandth = 1e-3;   // the line's integers are thousandths of an effort

// of the strongest devices on sale: sigma.7 20 N and 0.4 N·m, Premium 6-DoF 22 N and 0.5 N·m
constexpr double kMostForce = 30;    // what the line has room for [N]
constexpr double kMostTorque = 0.6;  // [N·m]

// counts/ns² of 100 m/s², as of other arms (EncoderNoise), and of 10⁴ rad/s²: a throw turns a
// handle by 3000 rad/s², and the potentiometers of a gimbal tremble by some milliradians
constexpr Axis kPlace{
    .angle = kMetre, .torque = kNewton / kThousandth, .most_acceleration = 1e2 / kMetre * 1e-18};
constexpr Axis kTurn{.angle = kRadian,
                     .torque = kNewtonMetre / kThousandth,
                     .most_acceleration = 1e4 / kRadian * 1e-18};

}  // namespace

const Arm& own_device_arm() {
  static const Arm kArm{
      .name = "device of your own",
      .model = 7,
      .motors = 6,
      .encoders = 6,
      .buttons = 8,
      .max_force = kMostForce,
      .max_torque = kMostTorque,
      // its numbers are no currents: what limits them is max_force and max_torque alone
      .most_effort = kThousandth * kFirmwareMaxMilliamperes,
      .axes = {kPlace, kPlace, kPlace, kTurn, kTurn, kTurn},
      .find =
          [](const JointAngles& q, Pose& X_BH) {
            X_BH = {{q[0], q[1], q[2]}, from_rotation_vector({q[3], q[4], q[5]})};
            return true;
          },
      // the numbers are the wrench itself, about the axes of B
      .jacobian =
          [](const JointAngles&, const Pose&, HandleJacobian& J) {
            for (int i = 0; i < 3; ++i) {
              J[static_cast<size_t>(i)].v[i] = J[static_cast<size_t>(i + 3)].w[i] = 1;
            }
            return true;
          },
      .solve =
          [](const Pose& X_BH, JointAngles& q) {
            const Vec3 r = to_rotation_vector(X_BH.q);
            q = {X_BH.p.x, X_BH.p.y, X_BH.p.z, r.x, r.y, r.z};
            return true;
          },
  };
  return kArm;
}

std::unique_ptr<Device> open_own_device(const DeviceConfig& config, FileDescriptor node) {
  return open_motor_device(own_device_arm(), config, std::move(node));
}

}  // namespace haptic
