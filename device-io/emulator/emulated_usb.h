// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

using UsbBytes = std::vector<uint8_t>;

inline constexpr size_t kRemembered = 50;  // reports that a liar remembers

struct UsbDescriptors {
  uint16_t vendor = 0, product = 0;
  UsbBytes device;                   // 18 bytes
  UsbBytes configuration;            // with its interfaces and endpoints
  UsbBytes hid_report;               // empty: no HID device
  std::vector<std::string> strings;  // manufacturer, product, serial number: indices 1, 2, 3
};

/// The eight bytes of a control request.
struct UsbSetup {
  uint8_t type = 0, request = 0;
  uint16_t value = 0, index = 0, length = 0;
};

/// A USB device as its bus sees it, without a bus: the same object stands behind umockdev, behind
/// QEMU's USB redirection, and behind a driver's state machine in lockstep. Time is an argument, so
/// that it may be virtual; calls come from one thread, with times that never decrease.
class EmulatedUsb {
 public:
  virtual ~EmulatedUsb() = default;

  virtual const UsbDescriptors& descriptors() const = 0;

  /// A class or vendor request; the front end answers standard ones from descriptors(). False: the
  /// device stalls.
  virtual bool control(const UsbSetup& setup, const UsbBytes& out, UsbBytes& in, int64_t t_ns) = 0;

  /// A packet of an OUT endpoint.
  virtual void take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) = 0;

  /// A packet of an IN endpoint, at most `most` bytes. False: it has nothing now (NAK).
  virtual bool give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) = 0;
};

}  // namespace haptic
