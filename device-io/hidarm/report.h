// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device-io/motors/motor_mailbox.h"

namespace haptic {

/// Reports of the WoodenHaptics' mbed (WoodenHaptics/woody-experimental, mbed-code), little endian
/// and without numbers. In: the counts of the encoders A, B, C and a counter of reports, each 16
/// bits. Out: the currents of the motors [mA], and 16 bits without meaning.
inline constexpr size_t kHidArmReport = 8;

/// An output report as hidapi takes it, with the report's number first, which is 0.
using HidArmCommand = std::array<uint8_t, 1 + kHidArmReport>;
HidArmCommand encode_hid_arm(const std::array<int16_t, 3>& milliamperes) noexcept;

/// Takes a report; false: it has another length. `counter` is the report's, and its low byte the
/// sample's number.
bool decode_hid_arm(std::span<const uint8_t> report, MotorSample& sample,
                    uint16_t& counter) noexcept;

}  // namespace haptic
