// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/spacemouse/report.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr uint8_t kTranslations = 1, kRotations = 2, kButtons = 3,
                  kBattery = 0x17;        // first byte of a report
constexpr size_t kHalf = 7, kWhole = 13;  // bytes of three axes, of six
constexpr size_t kFewestButtons = 3;      // bytes; the Navigator's
constexpr size_t kButtonBytes = 4;        // what `buttons` has room for

void take_axes(std::span<const uint8_t> report, size_t first, SpaceMouseInput& input) noexcept {
  for (size_t i = 0; 2 * i + 2 < report.size(); ++i) {
    const auto word = static_cast<uint16_t>(report[1 + 2 * i] | report[2 + 2 * i] << 8);
    input.axes[first + i] = static_cast<int16_t>(word);
  }
}

}  // namespace

SpaceMouseReport take_report(std::span<const uint8_t> report, SpaceMouseInput& input) noexcept {
  if (report.empty()) return SpaceMouseReport::kInvalid;
  const size_t size = report.size();
  switch (report[0]) {
    case kTranslations:
      if (size != kHalf && size != kWhole) return SpaceMouseReport::kInvalid;
      take_axes(report, 0, input);
      return SpaceMouseReport::kAxes;
    case kRotations:
      if (size != kHalf) return SpaceMouseReport::kInvalid;
      take_axes(report, 3, input);
      return SpaceMouseReport::kAxes;
    case kButtons:
      if (size < kFewestButtons || size > kWhole) return SpaceMouseReport::kInvalid;
      input.buttons = 0;
      for (size_t i = 0; i < std::min(size - 1, kButtonBytes); ++i) {
        input.buttons |= uint32_t{report[1 + i]} << (8 * i);
      }
      return SpaceMouseReport::kButtons;
    case kBattery:
      return SpaceMouseReport::kOther;
    default:
      return SpaceMouseReport::kInvalid;
  }
}

}  // namespace haptic
