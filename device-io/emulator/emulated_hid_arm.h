// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <deque>
#include <random>

#include "device-io/emulator/emulated_usb.h"
#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"

namespace haptic {

struct EmulatedHidArmOptions {
  PlantLoad load{};            // beside hand and motors
  SimulatedHandConfig hand{};  // the device and the hand that holds it
  HidArmConfig arm{};          // its lengths, capstans, encoders and signs
  std::string product{"HID DEVICE"}, serial{"0123456789"};  // as mbed's library has them
};

/// A WoodenHaptics with the mbed firmware: 8 bytes each way, a report each millisecond with a
/// counter, the amplifiers off after 0.5 s of silence. The handle is held by a hand (HandPlant).
/// Its joints are chained here by quaternions and found by Newton's method, and its force follows
/// by virtual work from differences, not by the driver's formulas. Source of the bytes and times:
/// WoodenHaptics/woody-experimental, mbed-code/WoodenHapticsHID/main.cpp.
class EmulatedHidArm final : public EmulatedUsb {
 public:
  explicit EmulatedHidArm(const EmulatedHidArmOptions& options);

  const UsbDescriptors& descriptors() const override { return descriptors_; }
  bool control(const UsbSetup& setup, const UsbBytes& out, UsbBytes& in, int64_t t_ns) override;
  void take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) override;
  bool give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) override;

  void lie(EmulatorFault how) { lie_ = how; }

  const HandPlant& plant() const { return plant_; }
  /// On the hand, by the motors [N].
  const Vec3& force_B() const { return force_B_; }
  const std::array<int, 3>& milliamperes() const { return milliamperes_; }
  bool is_enabled() const { return enabled_; }
  uint64_t commands() const { return commands_; }

 private:
  void advance_to(int64_t t_ns);
  void report();
  bool loses() { return lie_ == EmulatorFault::kLoses && random_() % 10 == 0; }
  Vec3 tip(const Vec3& angles) const;
  void sense();
  Vec3 motor_force() const;

  EmulatedHidArmOptions options_;
  UsbDescriptors descriptors_;
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::deque<UsbBytes> said_, to_host_;
  uint16_t counter_ = 0;
  std::array<int, 3> counts_{}, mirror_{}, milliamperes_{};
  bool enabled_ = false;
  uint64_t commands_ = 0;
  HandPlant plant_;
  Intention intention_;
  Vec3 angles_{0.0, 0.6, 1.2};  // from which Newton's method begins: an elbow that is up
  Vec3 force_B_;
  int64_t t_ns_ = 0, reported_ns_ = 0, commanded_ns_ = 0;
  std::minstd_rand random_{1};
};

}  // namespace haptic
