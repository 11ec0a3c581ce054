// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "device-io/device.h"
#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"

namespace haptic::test {

using Lie = EmulatorFault;

/// A driver and the emulated device before it, on virtual time: a read first lets time pass for
/// the device and its line.
class DriverBench : public Device {
 public:
  DeviceCaps caps() const override { return driver_->caps(); }
  std::string description() const override { return driver_->description(); }
  bool read(const TickTime& tick, DeviceState& state) override {
    pass(tick.now_ns);
    return driver_->read(tick, state);
  }
  void write(const Wrench& F_B) override { driver_->write(F_B); }
  Wrench holding(const GravityConfig& gravity) const override { return driver_->holding(gravity); }
  void stop() override { driver_->stop(); }
  DeviceRelease release() const override { return driver_->release(); }

  /// Time passes for the device and the line only.
  virtual void pass(int64_t t_ns) = 0;
  virtual void lie(Lie how) = 0;
  /// The device loses its power, or the plug is pulled.
  virtual void cut() = 0;
  /// Another process says this to the device over the same node.
  virtual void tell(std::span<const uint8_t> bytes) = 0;
  void tell(std::string_view bytes) {
    tell(std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()));
  }
  /// Up to where time has passed.
  virtual int64_t t_ns() const = 0;
  /// Descriptor of the driver's end; −1: it has none.
  virtual int node() const { return -1; }
  virtual const HandPlant& plant() const = 0;
  /// On the hand, by the motors.
  virtual Wrench felt_B() const = 0;
  /// Of the motor that works most, in the device's own unit.
  virtual double effort() const = 0;
  /// Answers that an honest device does not give, by the driver's account.
  virtual uint64_t oddities() const = 0;

  /// What the line takes each way, or the way to the host; bytes keep their order [ns].
  int64_t delay_ns = 0;
  /// That lies, where the emulated device lets one choose.
  size_t encoder = 1;
  static constexpr int64_t kStartNs = 1'000'000'000;  // of virtual time

 protected:
  std::unique_ptr<Device> driver_;
};

/// The largest size of any of them.
template <typename Numbers>
double largest_of(const Numbers& numbers) {
  double largest = 0;
  for (const auto n : numbers) largest = n < -largest ? -n : n > largest ? n : largest;
  return largest;
}

}  // namespace haptic::test
