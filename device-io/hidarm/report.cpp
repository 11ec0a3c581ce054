// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hidarm/report.h"

namespace haptic {
namespace {

uint16_t word_at(std::span<const uint8_t> bytes, size_t i) {
  return static_cast<uint16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
}

}  // namespace

HidArmCommand encode_hid_arm(const std::array<int16_t, 3>& milliamperes) noexcept {
  HidArmCommand report{};
  for (size_t i = 0; i < milliamperes.size(); ++i) {
    const auto word = static_cast<uint16_t>(milliamperes[i]);
    report[1 + 2 * i] = static_cast<uint8_t>(word & 0xff);
    report[2 + 2 * i] = static_cast<uint8_t>(word >> 8);
  }
  return report;
}

bool decode_hid_arm(std::span<const uint8_t> report, MotorSample& sample,
                    uint16_t& counter) noexcept {
  if (report.size() != kHidArmReport) return false;
  for (size_t i = 0; i < sample.counts.size(); ++i) {
    sample.counts[i] = static_cast<int16_t>(word_at(report, i));
  }
  counter = word_at(report, 3);
  sample.number = static_cast<uint8_t>(counter & 0xff);
  return true;
}

}  // namespace haptic
