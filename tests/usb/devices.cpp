// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/usb/devices.h"
#include <stdexcept>
namespace haptic::test {
namespace {
struct Dumb : EmulatedUsb, CountedDevice {
  UsbDescriptors d;
  Dumb(uint16_t v, uint16_t p) {
    d.vendor = v;
    d.product = p;
    d.device = {18,         1,
                0x00,       0x02,
                0,          0,
                0,          64,
                (uint8_t)v, (uint8_t)(v >> 8),
                (uint8_t)p, (uint8_t)(p >> 8),
                0x00,       0x04,
                1,          2,
                3,          1};
    d.configuration = {9,    2, 32, 0, 1,    1, 0,  0x80, 45, 9, 4, 0,    0, 2,  0xff, 0xff,
                       0xff, 2, 7,  5, 0x81, 2, 64, 0,    0,  7, 5, 0x02, 2, 64, 0,    0};
    d.strings = {"emulated", "thing", "E1"};
  }
  const UsbDescriptors& descriptors() const override { return d; }
  bool control(const UsbSetup&, const UsbBytes&, UsbBytes&, int64_t) override { return true; }
  void take(uint8_t, const uint8_t*, size_t, int64_t) override {}
  bool give(uint8_t, size_t, UsbBytes&, int64_t) override { return false; }
  EmulatedUsb& usb() override { return *this; }
  std::string account() const override { return "x=1"; }
};
}  // namespace
std::unique_ptr<CountedDevice> make_device(const std::string& kind) {
  if (kind == "falcon") return std::make_unique<Dumb>(0x0403, 0xcb48);
  if (kind == "spacemouse") return std::make_unique<Dumb>(0x256f, 0xc635);
  return std::make_unique<Dumb>(0x1234, 0x0006);
}
}  // namespace haptic::test
