// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// Most motors of any device here; those that a device lacks are zero.
inline constexpr size_t kMostMotors = 6;

using MotorCounts = std::array<int32_t, kMostMotors>;  // of the encoders on the motors

}  // namespace haptic
