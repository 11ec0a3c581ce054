// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/contact_age.cpp: age counts from the answered ServoFrame.
#include "servo/safety/contact_age.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "proto/math/units.h"
#include "proto/wire/wire.h"

using haptic::Age;
using haptic::Arrival;
using haptic::ContactWeight;
using haptic::kMs;
using haptic::kTick;
using haptic::weigh_contacts;

namespace {

/// A servo at 1 kHz with a contact that answers every `period` ticks until `dies_at`, and again
/// from `returns_at` on.
struct Run {
  int64_t period = 1, dies_at = 1 << 30, returns_at = 1 << 30;
  Age age;
  Arrival arrival;

  ContactWeight tick(int64_t k) {
    const bool alive = k < dies_at || k >= returns_at;
    if (alive && k % period == 0 && k > 0) {
      arrival.present = true;
      ++arrival.seq;
      arrival.answers_t_ns = (k - 1) * kMs;
    }
    return weigh_contacts(age, arrival, k * kMs, kTick);
  }
};

}  // namespace

TEST_CASE("contact age: nothing is rendered before the first set", "[servo]") {
  Run run;
  const ContactWeight w = run.tick(0);
  CHECK(w.weight == 0);
  CHECK(w.flags == haptic::kServoNoContactSet);
}

TEST_CASE("contact age: hold is three median periods within 20 and 100 ms", "[servo]") {
  for (const auto& [period, hold_ms] : {std::pair<int64_t, int64_t>{1, 20}, {10, 30}, {50, 100}}) {
    Run run;
    run.period = period;
    for (int64_t k = 0; k < 20 * period; ++k) run.tick(k);
    CAPTURE(period);
    CHECK(hold_ns(run.age) == hold_ms * kMs);
  }
}

TEST_CASE("contact age: a dead contact is held 20 ms, fades over 50 ms, then nothing", "[servo]") {
  Run run;
  run.dies_at = 100;  // the last set answers tick 98 and is seen at tick 99
  double before = 1;
  for (int64_t k = 0; k < 250; ++k) {
    const ContactWeight w = run.tick(k);
    const int64_t old = k - 98;
    CAPTURE(k, old, w.weight);
    if (k > 1 && old <= 20) CHECK(w.weight == 1);
    if (old > 20 && old < 70) {
      CHECK(w.weight == Approx((70.0 - static_cast<double>(old)) / 50));
      CHECK((w.flags & haptic::kServoFading) != 0);
    }
    if (old >= 70) {
      CHECK(w.weight == 0);
      CHECK((w.flags & haptic::kServoStale) != 0);
    }
    if (k > 1) CHECK(std::fabs(w.weight - before) <= 0.0201);  // never a step
    before = w.weight;
  }
}

TEST_CASE("contact age: a set that returns never steps up, once nothing was rendered by a ramp",
          "[servo]") {
  // in mid-fade, or after it: then five fresh sets reopen through 50 ms
  const int64_t returns = GENERATE(150, 300);
  CAPTURE(returns);
  Run run;
  run.dies_at = 100;
  run.returns_at = returns;
  double before = 1;
  int64_t first_force = 0, full_force = 0;
  for (int64_t k = 0; k < 500; ++k) {
    const ContactWeight w = run.tick(k);
    if (k > 300 && first_force == 0 && w.weight > 0) first_force = k;
    if (k > 300 && full_force == 0 && w.weight == 1) full_force = k;
    CAPTURE(k);
    if (k > 1) CHECK(std::fabs(w.weight - before) <= 0.0201);
    before = w.weight;
  }
  CHECK(before == 1);
  if (returns < 300) return;
  CHECK(first_force == 304);  // sets arrive at 300, 301, 302, 303, 304
  CHECK(full_force >= 353);
  CHECK(full_force <= 354);
}

TEST_CASE("contact age: sets that are already too old on arrival are not rendered", "[servo]") {
  // a contact that answers every tick, but always 200 ms late
  Age age;
  for (int64_t k = 0; k < 1000; ++k) {
    const Arrival arrival{true, static_cast<uint64_t>(k), (k - 200) * kMs, true};
    CHECK(weigh_contacts(age, arrival, k * kMs, kTick).weight == 0);
  }
}

TEST_CASE("contact age: a restarted contact with the same sequence number is news", "[servo]") {
  Age age;
  weigh_contacts(age, {true, 0, 0, true}, 1 * kMs, kTick);
  weigh_contacts(age, {true, 0, 50 * kMs, false}, 51 * kMs, kTick);
  CHECK(age.answered_ns == 50 * kMs);
}
