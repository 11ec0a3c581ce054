// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "device-io/spacemouse/deflection.h"

namespace haptic {

/// The next input report of a HID device, at once: its size; 0: there is none; negative: the device
/// has gone, and is not asked again.
using NextReport = std::function<int(std::span<uint8_t> report)>;

/// A 3Dconnexion knob with six axes: a *rate* device without actuators. Its deflection commands the
/// velocity of a virtual handle, integrated from tick to tick, which begins in the middle of the
/// workspace and stays within it. Whatever is written to it is felt by nobody.
///
/// A knob at rest is silent, and that is no fault: it is lost only when it has gone. A deflected
/// one reports every 8 to 16 ms; one that has said nothing for kReleasedNs is taken as let go, so
/// that a lost last report does not move the handle on for ever.
class SpaceMouse final : public Device {
 public:
  SpaceMouse(const DeviceConfig& config, std::string name, NextReport next_report);

  /// Neither force nor torque.
  DeviceCaps caps() const override { return {}; }
  std::string description() const override;
  /// Takes at most kMostReports; what is more waits for the next tick.
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& /*F_B*/) override {}
  void stop() override {}
  bool tap(HearBytes hears) override {
    hears_ = std::move(hears);
    return true;
  }

  /// Reports that are none of this family's.
  uint64_t rejected() const { return rejected_; }

  static constexpr int64_t kReleasedNs = 200'000'000;
  static constexpr int kMostReports = 64;  // as many as the kernel keeps

 private:
  void hear(int64_t t_ns);
  void move(int64_t t_ns);

  RateDeviceConfig rate_;
  HandleRange range_;
  std::string name_;
  NextReport next_report_;
  HearBytes hears_;
  SpaceMouseInput input_;
  DeviceState last_{};
  int64_t heard_ns_ = 0;  // the axes
  uint64_t rejected_ = 0;
  bool started_ = false, gone_ = false;
};

}  // namespace haptic
