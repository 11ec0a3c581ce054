// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/owndevice/own_device_arm.h"

#include <cmath>

namespace haptic {
namespace {

constexpr double kMetre = 1e-6;        // a count of position; finer than any device's [m]
constexpr double kRadian = 1e-5;       // a count of the rotation vector [rad]
constexpr double kNewton = 5e-3;       // a number of the line; of force [N]
constexpr double kNewtonMetre = 1e-4;  // of torque [N·m]
// the line's integers are thousandths of what Arm calls a current
constexpr double kThousandth = 1e-3;

// of the strongest devices on sale: sigma.7 20 N and 0.4 N·m, Premium 6-DoF 22 N and 0.5 N·m
constexpr double kMostForce = 30;    // what the line has room for [N]
constexpr double kMostTorque = 0.6;  // [N·m]

// counts/ns² of 100 m/s², as of other arms (EncoderNoise), and of 10⁴ rad/s²: a throw turns a
// handle by 3000 rad/s², and the potentiometers of a gimbal tremble by some milliradians
constexpr double kMostAcceleration = 1e2 / kMetre * 1e-18;
constexpr double kMostTurning = 1e4 / kRadian * 1e-18;

Vec3 position_of(const JointAngles& q) {
  return {q[0], q[1], q[2]};
}
Vec3 rotation_of(const JointAngles& q) {
  return {q[3], q[4], q[5]};
}

}  // namespace

const Arm& own_device_arm() {
  static constexpr Arm kArm{
      .name = "device of your own",
      .model = 7,
      .motors = 6,
      .encoders = 6,
      .buttons = 8,
      .max_force = kMostForce,
      .max_torque = kMostTorque,
      .most_acceleration = {kMostAcceleration, kMostAcceleration, kMostAcceleration, kMostTurning,
                            kMostTurning, kMostTurning},
      .angles =
          [](const MotorCounts& n) {
            return JointAngles{kMetre * n[0],  kMetre * n[1],  kMetre * n[2],
                               kRadian * n[3], kRadian * n[4], kRadian * n[5]};
          },
      .counts =
          [](const JointAngles& q) {
            MotorCounts n{};
            for (size_t i = 0; i < n.size(); ++i) {
              n[i] = static_cast<int32_t>(std::floor(q[i] / (i < 3 ? kMetre : kRadian)));
            }
            return n;
          },
      .pose =
          [](const JointAngles& q) {
            return Pose{position_of(q), from_rotation_vector(rotation_of(q))};
          },
      .solve =
          [](const Pose& X_BH, JointAngles& q) {
            const Vec3 r = to_rotation_vector(X_BH.q);
            q = {X_BH.p.x, X_BH.p.y, X_BH.p.z, r.x, r.y, r.z};
            return true;
          },
      .currents =
          [](const JointAngles&, const Wrench& F_B) {
            const Vec3 f = kThousandth / kNewton * F_B.f, t = kThousandth / kNewtonMetre * F_B.t;
            return MotorAmperes{f.x, f.y, f.z, t.x, t.y, t.z};
          },
      .wrench =
          [](const JointAngles&, const MotorAmperes& a) {
            return Wrench{kNewton / kThousandth * Vec3{a[0], a[1], a[2]},
                          kNewtonMetre / kThousandth * Vec3{a[3], a[4], a[5]}};
          },
  };
  return kArm;
}

}  // namespace haptic
