// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/haply.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device-io/plugged/find_node.h"

namespace haptic {
namespace {

// of the handle, as kTipAcceleration; near the edge an elbow moves twice as fast as the handle
constexpr double kMostAcceleration = 2 * 100;  // [m/s²]

}  // namespace

Arm haply_arm(const PantographConfig& config) {
  const PantographGeometry geometry{config.proximal, config.distal, config.base};
  // an axis is that of a port, from 0
  const std::array<size_t, 2> ports{config.port_1 == 1 ? 0u : 1u, config.port_1 == 1 ? 1u : 0u};
  const std::array signs{config.sign_1, config.sign_2};
  const std::array offsets{config.offset_1, config.offset_2};
  Arm arm;
  arm.name = "Haply 2-DoF board with a pantograph";
  arm.motors = arm.encoders = 2;
  arm.max_force = 5;  // above what its motors can do anywhere in the workspace [N]
  arm.cutoff = config.velocity_cutoff;
  arm.numbers = 1 / kHaplyTorqueUnit;
  arm.most_effort = config.max_torque;
  for (size_t i = 0; i < 2; ++i) {
    const double angle = angle_of_count(signs[i], config.counts_per_turn);
    arm.axes[ports[i]] = {angle, 0, offsets[i], signs[i] * config.reduction,
                          kMostAcceleration / config.proximal / std::fabs(angle) * 1e-18};
  }
  arm.find = [geometry, ports](const JointAngles& q, Pose& X_BH) {
    return find_pantograph_handle(geometry, {q[ports[0]], q[ports[1]]}, X_BH.p);
  };
  arm.jacobian = [geometry, ports](const JointAngles& q, const Pose& X_BH, HandleJacobian& J) {
    std::array<Vec3, 2> links;
    const PantographAngles angles{q[ports[0]], q[ports[1]]};
    if (!pantograph_jacobian(geometry, angles, X_BH.p, links)) return false;
    for (size_t i = 0; i < 2; ++i) J[ports[i]].v = links[i];
    return true;
  };
  arm.links = [geometry, ports](const LinkMasses& links, const JointAngles& q, const Pose& X_BH) {
    return pantograph_moment(geometry, links, {q[ports[0]], q[ports[1]]}, X_BH.p);
  };
  return arm;
}

MotorFlags haply_flags() {
  // zeros behind half a question would be a reset, after which the board knows no motors and holds
  // its torques
  const HaplyTorques zero = encode_haply_torques(kHaplyDevice, {});
  std::array<uint8_t, kHaplyPadding.size() + zero.size()> bytes;
  std::ranges::copy(zero, std::ranges::copy(kHaplyPadding, bytes.begin()).out);
  return {.release = release_by(ReleaseBy::kWrite, bytes)};
}

Haply::Haply(const DeviceConfig& config, FileDescriptor node, std::shared_ptr<MotorMailbox> mailbox)
    : ThreeMotorDevice(haply_arm(config.pantograph), haply_flags(), config, mailbox),
      line_(std::string(view(config.serial.path)), std::move(node), *mailbox) {}

std::string Haply::description() const {
  return ThreeMotorDevice::description() +
         (line_.is_new() ? ", counting from where its handle is now, which must be its home"
                         : ", counting on from an earlier session") +
         "; force out of its plane is dropped";
}

bool Haply::read(const TickTime& tick, DeviceState& state) {
  line_.hear(tick.now_ns);
  return ThreeMotorDevice::read(tick, state);
}

void Haply::write(const Wrench& F_B) {
  ThreeMotorDevice::write(F_B);
  line_.say(now_ns());
}

void Haply::stop() {
  ThreeMotorDevice::write({});
  line_.stop();
}

std::unique_ptr<Device> open_haply(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_node(config);
  return std::make_unique<Haply>(config, std::move(node));
}

}  // namespace haptic
