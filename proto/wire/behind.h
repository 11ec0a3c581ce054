// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/wire/hands.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Since when a process has left out some of its cycles in every second.
class BehindSince {
 public:
  /// `skipped`: cycles, since start. Returns the instant [ns]; 0: it keeps up.
  int64_t seen(uint64_t skipped, int64_t t_ns) {
    if (skipped != skipped_) {
      if (since_ns_ == 0) since_ns_ = t_ns;
      skipped_ = skipped;
      last_ns_ = t_ns;
    } else if (t_ns - last_ns_ > kForgiven) {
      since_ns_ = 0;
    }
    return since_ns_;
  }

 private:
  static constexpr int64_t kForgiven = 1'000'000'000;  // [ns]
  uint64_t skipped_ = 0;
  int64_t since_ns_ = 0, last_ns_ = 0;
};

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
