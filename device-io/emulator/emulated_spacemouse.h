// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <random>

#include "device-io/emulator/emulated_usb.h"
#include "device-io/emulator/fault_order.h"

namespace haptic {

struct EmulatedSpaceMouseOptions {
  bool whole = false;    // one report of 13 bytes, not two of 7
  uint16_t product = 0;  // another id of 3Dconnexion's own vendor id; 0: that of the model
  /// Deflection in counts by time since the start [s].
  std::function<std::array<int, 6>(double t)> hand = [](double) { return std::array<int, 6>{}; };
  std::function<uint32_t(double t)> buttons = [](double) { return 0u; };
};

/// A 3Dconnexion SpaceNavigator (or, with `whole`, a SpaceMouse Wireless): every 8 ms a report
/// while it is deflected, translations and rotations in turn; three of each that are zero; then
/// silence. Source of bytes and times: AndunHH/spacemouse, SpaceNavigator.md (recorded on the bus).
class EmulatedSpaceMouse final : public EmulatedUsb {
 public:
  explicit EmulatedSpaceMouse(const EmulatedSpaceMouseOptions& options);

  const UsbDescriptors& descriptors() const override { return descriptors_; }
  bool control(const UsbSetup& setup, const UsbBytes& out, UsbBytes& in, int64_t t_ns) override;
  void take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) override;
  bool give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) override;

  void lie(EmulatorFault how) { lie_ = how; }
  bool is_lit() const { return lit_; }
  uint64_t reports() const { return reports_; }

 private:
  void report(double t);
  UsbBytes axes_report(std::array<int, 6> axes);
  void say(UsbBytes report);

  EmulatedSpaceMouseOptions options_;
  UsbDescriptors descriptors_;
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::deque<UsbBytes> to_host_, said_;
  uint32_t buttons_ = 0;
  int zeros_ = 0;  // reports without deflection since the last one with
  bool rotations_next_ = false, lit_ = false;
  int64_t began_ns_ = 0, reported_ns_ = 0;
  uint64_t reports_ = 0;
  std::minstd_rand random_{1};
};

}  // namespace haptic
