// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/age.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr int64_t kFade = 50 * kMs;    // duration of the fade
constexpr double kReopenTime = 0.050;  // duration of the ramp up [s]
constexpr int kFreshToReopen = 5;      // after a complete fade

int64_t median_of_intervals(const Age& age) {
  const size_t n = std::min(age.n_intervals, Age::kIntervals);
  HAPTIC_ASSERT(n > 0);
  auto sorted = age.intervals_ns;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

void take_in(Age& age, const Arrival& arrival, int64_t t_ns, const HoldLimits& limits) {
  const bool news = !age.any || !arrival.same_writer || arrival.seq != age.last_seq;
  if (!news) return;
  const int64_t interval = arrival.answers_t_ns - age.answered_ns;
  // intervals longer than the longest hold are pauses and say nothing about the rate
  if (age.any && interval > 0 && interval <= limits.most_ns) {
    age.intervals_ns[age.n_intervals++ % Age::kIntervals] = interval;
    age.median_ns = median_of_intervals(age);
  }
  age.any = true;
  age.last_seq = arrival.seq;
  age.answered_ns = arrival.answers_t_ns;
  if (age.closed && t_ns - age.answered_ns <= hold_ns(age, limits)) ++age.fresh;
}

}  // namespace

int64_t hold_ns(const Age& age, const HoldLimits& limits) {
  return std::clamp(3 * age.median_ns, limits.least_ns, limits.most_ns);
}

AgedWeight weigh(Age& age, const Arrival& arrival, int64_t t_ns, double dt,
                 const HoldLimits& limits) {
  HAPTIC_ASSERT(dt > 0 && age.weight >= 0 && age.weight <= 1);
  if (arrival.present) take_in(age, arrival, t_ns, limits);
  if (!age.any) return {0, AgeState::kNone};

  const int64_t hold = hold_ns(age, limits);
  const int64_t old = t_ns - age.answered_ns;
  if (old >= hold + kFade) {
    age.closed = true;
    age.fresh = 0;
  }
  if (age.closed && age.fresh < kFreshToReopen) {
    age.weight = 0;
    return {0, AgeState::kClosed};
  }
  age.closed = false;

  AgedWeight out{1, AgeState::kFresh};
  if (old > hold) {
    out.state = AgeState::kFading;
    out.weight = static_cast<double>(hold + kFade - old) / static_cast<double>(kFade);
  } else if (old > hold / 3) {
    out.state = AgeState::kHolding;
  }
  // rises by the ramp, falls at once
  const double reachable = age.weight + dt / kReopenTime;
  out.rises = reachable < out.weight;
  if (out.rises) out.weight = reachable;
  age.weight = out.weight;
  return out;
}

}  // namespace haptic
