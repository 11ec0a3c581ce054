// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptic {

/// Longest input report that is read: those of the family have 3 to 13 bytes.
inline constexpr size_t kSpaceMouseReport = 64;

/// A knob as its reports say: translations, then rotations, in counts about its own axes (x to the
/// right, y to the user, z down), and one bit per button.
struct SpaceMouseInput {
  std::array<int16_t, 6> axes{};
  uint32_t buttons = 0;
};

enum class SpaceMouseReport {
  kAxes,  // all of the axes, or half of them
  kButtons,
  kOther,    // nothing about the knob: a battery
  kInvalid,  // no report of this family
};

/// Takes an input report, its number first; `input` keeps what the report does not say. Number 1
/// has three translations in 7 bytes or all six axes in 13, whatever the model: the length decides.
/// Number 2 has three rotations in 7, number 3 buttons in 3 to 13; number 0x17 is a battery.
/// Little-endian. Sources: spacenavd, PySpaceMouse; AndunHH/spacemouse (recordings of the bus).
SpaceMouseReport take_report(std::span<const uint8_t> report, SpaceMouseInput& input) noexcept;

}  // namespace haptic
