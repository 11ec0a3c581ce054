// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/emulated_spacemouse.h"

#include <algorithm>
#include <stdexcept>

#include "device-io/emulator/emulated_usb.h"

namespace haptic {
namespace {

constexpr size_t kRememberedReports = 20;  // that a liar gives again
constexpr int64_t kReportNs = 8'000'000;   // [ns], as the device sends them
constexpr int kLastZeros = 3;              // of each kind, before it is silent

/// Page 1, usage 8: a multi-axis controller, with its three input reports and its light.
UsbBytes report_descriptor() {
  return {0x05, 0x01, 0x09, 0x08, 0xa1, 0x01,
          // report 1: x, y, z, of 16 bits, −350 to 350
          0xa1, 0x00, 0x85, 0x01, 0x16, 0xa2, 0xfe, 0x26, 0x5e, 0x01, 0x09, 0x30, 0x09, 0x31, 0x09,
          0x32, 0x75, 0x10, 0x95, 0x03, 0x81, 0x02, 0xc0,
          // report 2: rotations
          0xa1, 0x00, 0x85, 0x02, 0x09, 0x33, 0x09, 0x34, 0x09, 0x35, 0x75, 0x10, 0x95, 0x03, 0x81,
          0x02, 0xc0,
          // report 3: two buttons
          0xa1, 0x02, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29, 0x02, 0x15, 0x00, 0x25, 0x01, 0x75,
          0x01, 0x95, 0x02, 0x81, 0x02, 0x95, 0x0e, 0x81, 0x03, 0xc0,
          // report 4, out: its light
          0xa1, 0x02, 0x85, 0x04, 0x05, 0x08, 0x09, 0x4b, 0x75, 0x01, 0x95, 0x01, 0x91, 0x02, 0x95,
          0x07, 0x91, 0x03, 0xc0, 0xc0};
}

UsbDescriptors describe_spacemouse(const EmulatedSpaceMouseOptions& options) {
  const bool whole = options.whole || options.product != 0;
  UsbDescriptors all;
  all.vendor = whole ? 0x256f : 0x046d;
  all.product = whole ? 0xc62e : 0xc626;
  if (options.product != 0) all.product = options.product;
  const auto low = [](uint16_t word) { return static_cast<uint8_t>(word % 256); };
  const auto high = [](uint16_t word) { return static_cast<uint8_t>(word / 256); };
  all.hid_report = report_descriptor();
  const auto length = static_cast<uint16_t>(all.hid_report.size());
  all.device = {18,
                1,
                0x00,
                0x02,
                0,
                0,
                0,
                8,
                low(all.vendor),
                high(all.vendor),
                low(all.product),
                high(all.product),
                0x31,
                0x04,
                1,
                2,
                0,
                1};
  all.configuration = {
      9, 2,  34,   0,    1, 1, 0,    0xa0,        50,           9, 4, 0,    0, 1,  3, 0, 0, 0,
      9, 33, 0x11, 0x01, 0, 1, 0x22, low(length), high(length), 7, 5, 0x81, 3, 16, 0, 8};
  all.strings = {"3Dconnexion", whole ? "SpaceMouse Wireless" : "SpaceNavigator"};
  return all;
}

}  // namespace

EmulatedSpaceMouse::EmulatedSpaceMouse(const EmulatedSpaceMouseOptions& options)
    : options_(options), descriptors_(describe_spacemouse(options)) {}

bool EmulatedSpaceMouse::control(const UsbSetup& setup, const UsbBytes& out, UsbBytes&,
                                 int64_t t_ns) {
  constexpr uint8_t kToInterface = 0x21, kSetReport = 9, kSetIdle = 10;
  if (setup.type != kToInterface) return false;
  if (setup.request == kSetReport) take(0, out.data(), out.size(), t_ns);
  return setup.request == kSetReport || setup.request == kSetIdle;
}

void EmulatedSpaceMouse::take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t) {
  if (endpoint != 0) throw std::logic_error("a SpaceMouse has no OUT endpoint");
  constexpr uint8_t kLight = 4;
  if (size >= 2 && bytes[0] == kLight) lit_ = bytes[1] != 0;
}

UsbBytes EmulatedSpaceMouse::axes_report(std::array<int, 6> axes) {
  if (lie_ == EmulatorFault::kNoise) axes[1] += static_cast<int>(random_() % 61) - 30;
  if (lie_ == EmulatorFault::kFlipped) axes[1] = -axes[1];
  if (lie_ == EmulatorFault::kOverdone) axes.fill(32767);
  const size_t first = rotations_next_ && !options_.whole ? 3 : 0;
  UsbBytes report{static_cast<uint8_t>(first == 0 ? 1 : 2)};
  for (size_t i = first; i < (options_.whole ? 6 : first + 3); ++i) {
    const unsigned bits = static_cast<unsigned>(axes[i]) & 0xffff;
    report.insert(report.end(),
                  {static_cast<uint8_t>(bits & 255), static_cast<uint8_t>(bits >> 8)});
  }
  rotations_next_ = !rotations_next_;
  return report;
}

void EmulatedSpaceMouse::say(UsbBytes report) {
  ++reports_;
  if (lie_ == EmulatorFault::kFrozen && !said_.empty()) report = said_.front();
  said_.push_back(report);
  if (said_.size() > kRememberedReports) said_.pop_front();
  if (lie_ == EmulatorFault::kLoses && random_() % 10 == 0) return;
  if (lie_ == EmulatorFault::kDelayed) report = said_.front();
  if (lie_ != EmulatorFault::kHalves) return to_host_.push_back(report);
  const auto middle = report.begin() + static_cast<ptrdiff_t>(report.size() / 2);
  to_host_.push_back({report.begin(), middle});
  to_host_.push_back({middle, report.end()});
}

void EmulatedSpaceMouse::report(double t) {
  if (lie_ == EmulatorFault::kSilent) return;
  const uint32_t buttons = options_.buttons(t);
  if (buttons != buttons_) {
    buttons_ = buttons;
    return say({3, static_cast<uint8_t>(buttons & 255), static_cast<uint8_t>(buttons >> 8 & 255)});
  }
  const std::array<int, 6> axes = options_.hand(t);
  const bool rests = std::all_of(axes.begin(), axes.end(), [](int n) { return n == 0; });
  zeros_ = rests ? zeros_ + 1 : 0;
  const bool lies = lie_ != EmulatorFault::kHealthy && lie_ != EmulatorFault::kLoses;
  if (zeros_ > (options_.whole ? kLastZeros : 2 * kLastZeros) && !lies) return;
  say(axes_report(axes));
}

bool EmulatedSpaceMouse::give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) {
  if (endpoint != 0x81) throw std::logic_error("a SpaceMouse has one IN endpoint");
  if (began_ns_ == 0) began_ns_ = t_ns;
  if (t_ns - reported_ns_ >= kReportNs) {
    reported_ns_ = t_ns;
    report(1e-9 * static_cast<double>(t_ns - began_ns_));
  }
  if (to_host_.empty()) return false;
  packet = to_host_.front();
  to_host_.pop_front();
  packet.resize(std::min(packet.size(), most));
  return true;
}

}  // namespace haptic
