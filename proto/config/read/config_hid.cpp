// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "proto/config/devices.h"
#include "proto/config/read/config_device.h"

namespace haptic {

using enum Dimension;
namespace {

constexpr Range kDeadBands{0, 0.9};        // a share
constexpr Range kCounts{1, 32767};         // of an int16
constexpr Range kEncoderCounts{1, 1e7};    // of a turn
constexpr Range kHidCurrents{0, 6, true};  // [A]; amplifiers of such arms take no more

/// Signs are 1 or −1.
void read_signs(Section& section, std::string_view key, Vec3& signs) {
  Vec3 read = signs;
  if (!section.read_numbers(key, Range{-1, 1}, read)) return;
  for (int i = 0; i < 3; ++i) {
    if (read[i] != 1 && read[i] != -1) section.fail_at(key, "holds 1 or -1 for each joint");
  }
  signs = read;
}

}  // namespace

void read_hid_arm(Section& device, const std::filesystem::path&, DeviceConfig& config) {
  device.within("hid_arm", [&](Section& section) {
    HidArmConfig& arm = config.hid_arm;
    section.read_all({{"links", kLength, kPositive, arm.links},
                      {"capstans", kLength, kPositive, arm.capstans},
                      {"bodies", kLength, kPositive, arm.bodies}});
    read_signs(section, "signs", arm.signs);
    read_signs(section, "motor_signs", arm.motor_signs);
    section.read_all({{"homes", kAngle, kAny, arm.homes},
                      {"counts_per_turn", kEncoderCounts, arm.counts_per_turn},
                      {"torque_constant", kTorqueConstant, kPositive, arm.torque_constant},
                      {"max_current", kCurrent, kHidCurrents, arm.max_current},
                      {"velocity_cutoff", kFrequency, kPositive, arm.velocity_cutoff}});
  });
}

void read_rate(Section& device, const std::filesystem::path&, DeviceConfig& config) {
  device.within("rate", [&](Section& section) {
    RateDeviceConfig& rate = config.rate;
    section.read_all({{"speed", kSpeed, kPositive, rate.speed},
                      {"turn_rate", kAngularSpeed, kNotNegative, rate.turn_rate},
                      {"dead_band", kDeadBands, rate.dead_band},
                      {"full_scale", kCounts, rate.full_scale}});
  });
}

}  // namespace haptic
