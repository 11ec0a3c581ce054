// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hidarm/hid_arm.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "device-io/hidarm/hid_link.h"
#include "device-io/plugged/find_node.h"

namespace haptic {
namespace {

constexpr double kMaxForce = 5;  // of the design [N]
constexpr double kReach = 0.22;  // from the axis of A to the middle of the workspace [m]

DeviceRelease zero_force() {
  const HidArmCommand zero = encode_hid_arm({});
  DeviceRelease release{};
  release.by = static_cast<uint32_t>(ReleaseBy::kHidReport);
  release.size = zero.size();
  std::copy(zero.begin(), zero.end(), release.bytes.begin());
  return release;
}

/// Currents as the board takes them; where one exceeds `most` [A] all are scaled by one factor.
std::array<int16_t, 3> milliamperes(const Vec3& amperes, double most, bool& clipped) {
  const double largest =
      std::max({std::fabs(amperes.x), std::fabs(amperes.y), std::fabs(amperes.z)});
  clipped = largest > most;
  const double share = clipped ? most / largest : 1;
  std::array<int16_t, 3> whole;
  for (int i = 0; i < 3; ++i) {
    whole[static_cast<size_t>(i)] = static_cast<int16_t>(std::lround(1000 * share * amperes[i]));
  }
  return whole;
}

}  // namespace

WoodenHapticsGeometry hid_arm_geometry(const HidArmConfig& config) {
  WoodenHapticsGeometry g;
  g.shoulder_height = config.links.x;
  g.upper_arm = config.links.y;
  g.forearm = config.links.z;
  g.origin = {kReach, 0, config.links.x};
  g.counts_per_turn = config.counts_per_turn;
  g.torque_constant = config.torque_constant;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<size_t>(i);
    g.ratio[k] = config.bodies[i] / config.capstans[i];
    g.direction[k] = config.signs[i];
    g.torque_direction[k] = config.motor_signs[i];
    const double turns = config.homes[i] / (2 * std::numbers::pi);
    g.home_counts[k] =
        static_cast<int32_t>(std::lround(g.direction[k] * turns * g.counts_per_turn * g.ratio[k]));
  }
  return g;
}

ThreeMotorArm hid_arm(const HidArmConfig& config) {
  const WoodenHapticsGeometry geometry = hid_arm_geometry(config);
  const auto angles = std::make_shared<Vec3>();  // of the last sample
  ThreeMotorArm arm;
  arm.name = "WoodenHaptics over HID";
  arm.max_force = kMaxForce;
  arm.velocity_cutoff = config.velocity_cutoff;
  arm.most_acceleration = {kTipAcceleration, kTipAcceleration, kTipAcceleration};
  arm.place = [geometry, angles](const MotorCounts& counts, bool, Vec3& p_B) {
    *angles = joint_angles(geometry, counts);
    p_B = tip_position(geometry, *angles);
    return true;
  };
  arm.drive = [geometry, angles, most = config.max_current](
                  const Vec3& F_B, std::array<int16_t, 3>& motors, bool& clipped) {
    motors = milliamperes(motor_currents(geometry, *angles, F_B), most, clipped);
    return true;
  };
  arm.is_homed = [](uint8_t) { return true; };
  arm.buttons = [](uint8_t) { return 0u; };
  arm.command_flags = [](bool) { return uint8_t{0}; };
  arm.release = zero_force();
  return arm;
}

std::unique_ptr<Device> open_hid_arm(const DeviceConfig& config, FileDescriptor) {
  // hapticd keeps a file of its own on the same node, which several may open
  auto mailbox = std::make_shared<MotorMailbox>();
  auto link = std::make_shared<HidLink>(find_node(config), *mailbox);
  HidLink* const thread = link.get();
  return std::make_unique<ThreeMotorDevice>(
      hid_arm(config.hid_arm), config, mailbox,
      MotorLink{std::move(link), [thread] { thread->stop(); }, &thread->tap()});
}

}  // namespace haptic
