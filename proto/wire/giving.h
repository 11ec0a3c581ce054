// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "proto/wire/wire.h"

namespace haptic {

/// Why frames of a client are refused, and how to mend it; by GiverRefusal.
inline constexpr std::array<std::string_view, 11> kGiverRefusals{
    "",
    "a number is not finite, or a quaternion has not length 1",
    "it gives what it may not; see 'may' of its [[client]]",
    "its frames go back in time, come from the future, or are older than 0.5 s; a program that "
    "asks pushed() before each move() is in time",
    "it has used a servo tick that has not been, goes back, or is long ago",
    "a matrix is not symmetric, or has a negative direction",
    "an object is lighter than 1 g, turns more easily than a ball of 1 mm, or has 1000 t or more",
    "an object moves by itself faster than 1000 rad/s, or is stiffer than 10 kN/mm; state less "
    "stiffness or more mass",
    "an object is farther than reach ([sim]) from its place in the session file (are they "
    "metres?), "
    "or a place, speed or acceleration is beyond all hands",
    "its power is beyond max_power of its [[client]]",
    "a plane has no unit normal, a negative number, or an object or hand that there is not"};

constexpr std::string_view words_of(GiverRefusal refusal) {
  const auto number = static_cast<size_t>(refusal);
  return number < kGiverRefusals.size() ? kGiverRefusals[number] : "unknown";
}

/// States of a client that people are told of.
struct GiverFlagRow {
  uint32_t flag;  // GiverFlag
  std::string_view words;
};
inline constexpr std::array<GiverFlagRow, 4> kGiverFlags{
    {{kGiverLate, "late: what it gives is not felt"},
     {kGiverSoftened, "held back: an object answers otherwise than it says"},
     {kGiverCut, "cut: it gives the hand more power than max_power"},
     {kGiverLimited, "limited: its stiffness or damping is beyond the session's, or drives"}}};

}  // namespace haptic
