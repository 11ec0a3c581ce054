// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// What the age of the contacts does to the force. Ages count from the ServoFrame a set answers.
struct ContactAge {
  static constexpr size_t kIntervals = 9;
  std::array<int64_t, kIntervals> intervals_ns{};  // between the last answered frames
  size_t n_intervals = 0;
  int64_t answered_ns = 0;  // newest answered frame
  uint64_t last_seq = 0;
  bool any = false;     // a set was ever received
  bool closed = false;  // was too old: waiting for fresh sets
  int fresh_sets = 0;   // since it closed
  double weight = 1;    // last tick's; it never rises faster than the ramp
};

struct ContactWeight {
  double weight = 0;   // of the contacts in the force, 0 to 1
  uint32_t flags = 0;  // ServoFlag: holding, fading, stale, reopening, no set
};

/// The newest set as the servo sees it this tick.
struct ContactArrival {
  bool present = false;  // a set exists
  uint64_t seq = 0;
  int64_t answers_t_ns = 0;
  bool same_writer = true;  // false: first set of a restarted contact
};

/// Weight of the contacts at time t. Hold in full for clamp(3 × median period of the answers, 20
/// ms, 100 ms), then fade linearly over 50 ms; older on arrival: not rendered at all. Once faded
/// out, five fresh sets reopen. The weight rises through a 50 ms ramp only: never a step in either
/// direction.
ContactWeight weigh_contacts(ContactAge& age, const ContactArrival& arrival, int64_t t_ns,
                             double dt);

/// The hold in force [ns].
int64_t hold_ns(const ContactAge& age);

}  // namespace haptic
