// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// How the age of the contacts scales the force. Age counts from the ServoFrame that a set answers.
struct ContactAge {
  static constexpr size_t kIntervals = 9;
  std::array<int64_t, kIntervals> intervals_ns{};  // between the frames answered last
  size_t n_intervals = 0;
  int64_t median_ns = 0;    // of those intervals; 0: none yet
  int64_t answered_ns = 0;  // newest answered frame
  uint64_t last_seq = 0;
  bool any = false;     // a set has been received
  bool closed = false;  // the contacts were too old; waits for fresh sets
  int fresh_sets = 0;   // since it closed
  double weight = 1;    // of the last tick; rises no faster than the ramp
};

struct ContactWeight {
  double weight = 0;   // of the contacts in the force, 0 to 1
  uint32_t flags = 0;  // ServoFlag: holding, fading, stale, reopening, no set
};

/// The newest set, as the servo sees it this tick.
struct ContactArrival {
  bool present = false;  // a set exists
  uint64_t seq = 0;
  int64_t answers_t_ns = 0;
  bool same_writer = true;  // false: first set of a restarted contact process
};

/// Weight of the contacts at time t_ns. It is 1 for clamp(3 × median answer period, 20 ms, 100 ms),
/// then falls linearly to 0 over 50 ms; a set older than that on arrival is not rendered. After a
/// complete fade five fresh sets reopen the contacts. The weight rises by a 50 ms ramp only.
ContactWeight weigh_contacts(ContactAge& age, const ContactArrival& arrival, int64_t t_ns,
                             double dt);

/// Age up to which the contacts have full weight [ns].
int64_t hold_ns(const ContactAge& age);

}  // namespace haptic
