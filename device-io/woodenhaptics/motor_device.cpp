// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/motor_device.h"

#include <memory>
#include <utility>

#include "device-io/plugged/find_node.h"

namespace haptic {
namespace {

Arm limited_by(const SerialConfig& serial, Arm arm) {
  if (arm.most_effort == 0) arm.most_effort = serial.max_current;
  if (arm.cutoff == 0) arm.cutoff = serial.velocity_cutoff;
  return arm;
}

}  // namespace

MotorDevice::MotorDevice(const Arm& arm, const DeviceConfig& config, FileDescriptor node)
    : ArmDevice(limited_by(config.serial, arm), config),
      line_(arm_, std::string(view(config.serial.path)), std::move(node)) {
  take({.counts = line_.home()});
  last_.flags = kDeviceHeld | line_.flags();
}

std::string MotorDevice::description() const {
  return describe(line_.is_homed(), "rest the arm at home, press its button");
}

bool MotorDevice::read(const TickTime& tick, DeviceState& state) {
  const auto sample = line_.hear(tick.now_ns);
  if (sample) take(*sample);
  // nobody holds a button of a device that is gone
  if ((line_.flags() & kDeviceLost) != 0) last_.buttons = 0;
  return give(sample.has_value(), line_.flags(), state);
}

void MotorDevice::write(const Wrench& F_B) {
  if (line_.may_say()) line_.say(numbers_for(F_B));
}

std::unique_ptr<Device> open_motor_device(const Arm& arm, const DeviceConfig& config,
                                          FileDescriptor node) {
  if (!node.is_open()) node = open_node(config);
  return std::make_unique<MotorDevice>(arm, config, std::move(node));
}

}  // namespace haptic
