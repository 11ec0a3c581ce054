// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "proto/config/devices.h"
#include "proto/config/read/config_device.h"

namespace haptic {

using enum Dimension;
namespace {

constexpr Range kTurnCounts{1, 60'000};       // half a turn is in 16 bits
constexpr Range kBoardTorques{0, 0.3, true};  // [N·m]; a command is in 16 bits of 10 µN·m

/// 1 or −1.
void read_sign(Section& section, std::string_view key, double& sign) {
  double read = sign;
  if (!section.read_number(key, Range{-1, 1}, read)) return;
  if (read != 1 && read != -1) section.fail_at(key, "is 1 or -1");
  sign = read;
}

}  // namespace

void read_pantograph(Section& device, const std::filesystem::path&, DeviceConfig& config) {
  device.within("pantograph", [&](Section& section) {
    PantographConfig& arm = config.pantograph;
    section.read_all({{"proximal", kLength, kPositive, arm.proximal},
                      {"distal", kLength, kPositive, arm.distal},
                      {"base", kLength, kNotNegative, arm.base},
                      {"counts_per_turn", kTurnCounts, arm.counts_per_turn},
                      {"offset_1", kAngle, kAny, arm.offset_1},
                      {"offset_2", kAngle, kAny, arm.offset_2}});
    read_sign(section, "sign_1", arm.sign_1);
    read_sign(section, "sign_2", arm.sign_2);
    section.read_all({{"port_1", 1, 2, arm.port_1},
                      {"reduction", kPositive, arm.reduction},
                      {"max_torque", kTorque, kBoardTorques, arm.max_torque},
                      {"velocity_cutoff", kFrequency, kPositive, arm.velocity_cutoff}});
  });
}

}  // namespace haptic
