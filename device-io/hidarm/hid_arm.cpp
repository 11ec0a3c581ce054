// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hidarm/hid_arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device-io/hidarm/hid_link.h"
#include "device-io/plugged/find_node.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kReach = 0.22;  // from the axis of A to the middle of the workspace [m]

}  // namespace

Arm hid_arm(const HidArmConfig& config) {
  WoodenHapticsGeometry geometry;
  geometry.shoulder_height = config.links.x;
  geometry.upper_arm = config.links.y;
  geometry.forearm = config.links.z;
  geometry.origin = {kReach, 0, config.links.x};
  Arm arm = serial_arm(geometry);
  arm.name = "WoodenHaptics over HID";
  arm.cutoff = config.velocity_cutoff;
  arm.most_effort = config.max_current;
  for (int i = 0; i < 3; ++i) {
    const double ratio = config.bodies[i] / config.capstans[i];
    const double turns = config.homes[i] / (2 * kPi);
    const double home = config.signs[i] * turns * config.counts_per_turn * ratio;
    arm.axes[static_cast<size_t>(i)] = axis_of(
        {ratio, config.signs[i], config.motor_signs[i], static_cast<int32_t>(std::lround(home))},
        config.counts_per_turn, config.torque_constant);
  }
  return arm;
}

MotorFlags hid_arm_flags() {
  return {.release = release_by(ReleaseBy::kHidReport, encode_hid_arm({}))};
}

std::unique_ptr<Device> open_hid_arm(const DeviceConfig& config, FileDescriptor) {
  // hapticd keeps a file of its own on the same node, which several may open
  auto mailbox = std::make_shared<MotorMailbox>();
  auto link = std::make_shared<HidLink>(find_node(config), *mailbox);
  return std::make_unique<ThreeMotorDevice>(hid_arm(config.hid_arm), hid_arm_flags(), config,
                                            mailbox, std::move(link));
}

}  // namespace haptic
