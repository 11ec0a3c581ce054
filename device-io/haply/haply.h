// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "device-io/haply/haply_line.h"
#include "device-io/haply/pantograph.h"
#include "device-io/motors/three_motor_device.h"

namespace haptic {

/// A Haply board with a pantograph as an arm of two motors, in units of kHaplyTorqueUnit. Frame B
/// as in pantograph.h: with both motors before you and the handle on your side, x to the left, y
/// towards you, z up. The pose has z = 0 and the identity as orientation. Always homed: it counts
/// from where it was set up.
Arm haply_arm(const PantographConfig& config);
MotorFlags haply_flags();

/// The board on its serial line. A sample is one tick old, as with MotorDevice: a wall is stable
/// for K < (b + B)/(3T/2).
class Haply final : public ThreeMotorDevice {
 public:
  /// Takes the open node. Throws as HaplyLine does.
  Haply(const DeviceConfig& config, FileDescriptor node,
        std::shared_ptr<MotorMailbox> mailbox = std::make_shared<MotorMailbox>());

  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;

 private:
  HaplyLine line_;
};

}  // namespace haptic
