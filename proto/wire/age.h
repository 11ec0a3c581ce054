// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// How long what another process sends is used in full after it has become late.
struct HoldLimits {
  int64_t least_ns = 20'000'000, most_ns = 100'000'000;
};

/// The age of what another process sends: answers of contact to the servo, frames of a client to
/// sim. It counts from the instant that the newest one is about.
struct Age {
  static constexpr size_t kIntervals = 9;
  std::array<int64_t, kIntervals> intervals_ns{};  // between the instants of the last ones
  size_t n_intervals = 0;
  int64_t median_ns = 0;    // of those intervals; 0: none yet
  int64_t answered_ns = 0;  // instant of the newest
  uint64_t last_seq = 0;
  bool any = false;     // one has been received
  bool closed = false;  // they were too old; waits for fresh ones
  int fresh = 0;        // since it closed
  double weight = 1;    // of the last tick; rises no faster than the ramp
};

/// The newest one, as its reader sees it this tick.
struct Arrival {
  bool present = false;  // there is one
  uint64_t seq = 0;
  int64_t answers_t_ns = 0;
  bool same_writer = true;  // false: the first one of a restarted writer
};

enum class AgeState : uint32_t { kNone, kFresh, kHolding, kFading, kClosed };

struct AgedWeight {
  double weight = 0;  // 0 to 1
  AgeState state = AgeState::kNone;
  bool rises = false;  // by the ramp
};

/// Weight at time t_ns, dt [s] after the last. It is 1 for clamp(3 × median interval, least, most),
/// then falls linearly to 0 over 50 ms; what is older than that on arrival is not used. After a
/// complete fade five fresh ones reopen. The weight rises by a 50 ms ramp only.
AgedWeight weigh(Age& age, const Arrival& arrival, int64_t t_ns, double dt,
                 const HoldLimits& limits = {});

/// Age up to which the weight is full [ns].
int64_t hold_ns(const Age& age, const HoldLimits& limits = {});

}  // namespace haptic
