// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/desk/trial/byte_log.h"
#include "device-io/device.h"

namespace haptic {

/// Writes down what a device without a serial line and its driver say to each other: reports of HID
/// devices, packets of USB devices. It must outlive the device, whose thread it listens to; ask for
/// the pieces once the device has been destroyed.
class ByteRecord {
 public:
  ByteRecord();
  ByteRecord(const ByteRecord&) = delete;

  /// Begins; false: the driver does not tell.
  bool listen_to(Device& device);
  const std::vector<DeviceBytes>& pieces() const { return pieces_; }
  /// The record is full and its end is missing.
  bool is_cut() const { return cut_; }

 private:
  void add(bool by_device, std::span<const uint8_t> bytes, int64_t t_ns);

  std::vector<DeviceBytes> pieces_;
  int64_t begin_ns_ = 0;
  bool cut_ = false;
};

}  // namespace haptic
