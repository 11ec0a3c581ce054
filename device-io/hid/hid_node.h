// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

struct hid_device_;

namespace haptic {

/// A device with HID reports at a hidraw node, by hidapi: a thin shell. Neither read() nor write()
/// allocates while the device is there; hidapi's message about one that has gone does, once.
class HidNode {
 public:
  /// Throws DeviceError in one line.
  explicit HidNode(const std::string& path);
  ~HidNode();
  HidNode(const HidNode&) = delete;
  HidNode& operator=(const HidNode&) = delete;

  /// The next input report, with its number first if the device numbers them. Its size; 0: none has
  /// come within `wait_ms`; −1: the device has gone.
  int read(std::span<uint8_t> report, int wait_ms);

  /// An output report, its number first (0: not numbered). False: it was not taken. Waits until the
  /// device has taken it, a millisecond at 1 kHz.
  bool write(std::span<const uint8_t> report);

 private:
  struct Close {
    void operator()(hid_device_* device) const;
  };
  std::unique_ptr<hid_device_, Close> device_;
};

}  // namespace haptic
