// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>

namespace haptic {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180;  // [rad]
inline constexpr double kMm = 1e-3;           // [m]
inline constexpr double kTick = 1e-3;         // of the servo at 1 kHz [s]
inline constexpr int64_t kUs = 1'000;         // [ns]
inline constexpr int64_t kMs = 1'000'000;     // [ns]

}  // namespace haptic
