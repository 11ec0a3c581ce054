// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/falcon.h"

#include <cmath>
#include <utility>

#include "device-io/falcon/kinematics.h"
#include "device-io/falcon/packet.h"
#include "device-io/falcon/usb_link.h"

namespace haptic {
namespace {

constexpr uint8_t kReadyLight = 0x02;  // green in the firmware that libnifalcon describes
// 100 m/s² at the handle, where a count is at least 10 µm [counts/ns²]
constexpr double kMostAcceleration = 100 / 10e-6 * 1e-18;

}  // namespace

Arm falcon_arm(const FalconConfig& config) {
  static constexpr FalconGeometry kGeometry;
  Arm arm;
  arm.name = "Novint Falcon";
  arm.max_force = 8;  // of the design [N]; CHAI3D has the same
  arm.cutoff = config.velocity_cutoff;
  arm.numbers = kFalconWordPerTorque;
  arm.most_effort = kMostFalconWord / std::fabs(kFalconWordPerTorque);
  for (size_t i = 0; i < arm.motors; ++i) {
    arm.axes[i] = {kGeometry.angle_per_count, 0, kGeometry.home, 1, kMostAcceleration};
  }
  arm.find = [](const JointAngles& q, Pose& X_BH) {
    return find_falcon_handle(kGeometry, {q[0], q[1], q[2]}, X_BH.p);
  };
  arm.jacobian = [](const JointAngles&, const Pose& X_BH, HandleJacobian& J) {
    FalconPose pose;
    return solve_falcon(kGeometry, X_BH.p, pose) && falcon_jacobian(pose, J);
  };
  arm.down_B = {0, -1, 0};
  arm.links = [](const LinkMasses& links, const JointAngles&, const Pose& X_BH) {
    return falcon_moment(kGeometry, links, X_BH.p);
  };
  return arm;
}

MotorFlags falcon_flags() {
  return {.homed = kFalconLegs,
          .buttons = kFalconButtons,
          .ready = kFalconHoming | kReadyLight,
          .idle = kFalconHoming,
          .not_homed = "pull its grip fully out, then push it fully in",
          .release = release_by(ReleaseBy::kUsbBulk, encode_falcon({{}, kFalconHoming}),
                                kFalconInterface, kFalconOut)};
}

std::unique_ptr<Device> open_falcon(const DeviceConfig& config, FileDescriptor node) {
  auto mailbox = std::make_shared<MotorMailbox>();
  auto link = std::make_shared<FalconLink>(config, std::move(node), *mailbox);
  return std::make_unique<ThreeMotorDevice>(falcon_arm(config.falcon), falcon_flags(), config,
                                            mailbox, std::move(link));
}

}  // namespace haptic
