// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/wire/hands.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A process that does not keep up, as the servo judges it, and how people read of it.
struct BehindRow {
  uint32_t flag;            // ServoFlag
  const char* name;         // of the process
  std::string_view state;   // at present
  std::string_view past;    // in a session that is over
  std::string_view metric;  // its share of the time, where any
};
inline constexpr std::array<BehindRow, 3> kBehind{
    {{kServoLate, servo_name(kFirstHand), "servo falls behind", "the servo fell behind",
      "time in which the servo fell behind"},
     {kServoContactLate, contact_name(kFirstHand), "contact falls behind", "contact fell behind",
      "time in which contact fell behind"},
     {kServoSimLate, "sim", "sim falls behind", "sim fell behind",
      "time in which sim fell behind"}}};

}  // namespace haptic
