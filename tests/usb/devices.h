// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "device-io/emulator/emulated_usb.h"

namespace haptic::test {

/// An emulated device that says what has happened to it.
class CountedDevice {
 public:
  virtual ~CountedDevice() = default;
  virtual EmulatedUsb& usb() = 0;
  /// Lets time go on to the last instant before the account.
  virtual void end(int64_t /*t_ns*/) {}
  /// "key=value …": what it received and answered.
  virtual std::string account() const = 0;
};

/// By the kind of a config. Throws std::runtime_error if there is no such emulated device.
std::unique_ptr<CountedDevice> make_device(const std::string& kind);

}  // namespace haptic::test
