// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/contact_age.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/units.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

constexpr int64_t kMinHold = 20 * kMs;   // a set is at full weight at least this long
constexpr int64_t kMaxHold = 100 * kMs;  // and at most this long
constexpr int64_t kFade = 50 * kMs;      // duration of the fade
constexpr double kReopenTime = 0.050;    // duration of the ramp up [s]
constexpr int kFreshSetsToReopen = 5;    // after a complete fade

int64_t median_of_intervals(const ContactAge& age) {
  const size_t n = std::min(age.n_intervals, ContactAge::kIntervals);
  HAPTIC_ASSERT(n > 0);
  auto sorted = age.intervals_ns;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(n));
  return *middle;
}

void take_in(ContactAge& age, const ContactArrival& arrival, int64_t t_ns) {
  const bool news = !age.any || !arrival.same_writer || arrival.seq != age.last_seq;
  if (!news) return;
  const int64_t interval = arrival.answers_t_ns - age.answered_ns;
  // intervals longer than the longest hold are pauses and say nothing about the rate of contact
  if (age.any && interval > 0 && interval <= kMaxHold) {
    age.intervals_ns[age.n_intervals++ % ContactAge::kIntervals] = interval;
    age.median_ns = median_of_intervals(age);
  }
  age.any = true;
  age.last_seq = arrival.seq;
  age.answered_ns = arrival.answers_t_ns;
  if (age.closed && t_ns - age.answered_ns <= hold_ns(age)) ++age.fresh_sets;
}

}  // namespace

int64_t hold_ns(const ContactAge& age) {
  return std::clamp(3 * age.median_ns, kMinHold, kMaxHold);
}

ContactWeight weigh_contacts(ContactAge& age, const ContactArrival& arrival, int64_t t_ns,
                             double dt) {
  HAPTIC_ASSERT(dt > 0 && age.weight >= 0 && age.weight <= 1);
  if (arrival.present) take_in(age, arrival, t_ns);
  if (!age.any) return {0, kServoNoContactSet};

  const int64_t hold = hold_ns(age);
  const int64_t old = t_ns - age.answered_ns;
  if (old >= hold + kFade) {
    age.closed = true;
    age.fresh_sets = 0;
  }
  if (age.closed && age.fresh_sets < kFreshSetsToReopen) {
    age.weight = 0;
    return {0, kServoStale};
  }
  age.closed = false;

  ContactWeight out{1, 0};
  if (old > hold) {
    out.flags |= kServoFading;
    out.weight = static_cast<double>(hold + kFade - old) / static_cast<double>(kFade);
  } else if (old > hold / 3) {
    out.flags |= kServoHolding;
  }
  // rises by the ramp, falls at once
  const double reachable = age.weight + dt / kReopenTime;
  if (reachable < out.weight) {
    out.flags |= kServoReopening;
    out.weight = reachable;
  }
  age.weight = out.weight;
  return out;
}

}  // namespace haptic
