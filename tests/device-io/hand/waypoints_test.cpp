// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/waypoints.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "device-io/hand/intent.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

IntentConfig way() {
  IntentConfig config;
  config.tremor_amplitude = 0;
  config.n_waypoints = 3;
  config.waypoints[0] = {{{0.1, 0, 0}, {}}, 0, 0.5};
  config.waypoints[1] = {{{0.1, 0.2, 0}, from_rotation_vector({0.5, 0, 0})}, 2, 0.25};
  config.waypoints[2] = {{{0, 0.2, 0.1}, from_rotation_vector({0, -1, 0.2})}, 1, 0};
  return config;
}

}  // namespace

TEST_CASE("waypoints: the hand is where it is meant to be, and rests there", "[device-io]") {
  const IntentConfig config = way();
  const auto check_at = [&](double t, uint32_t place) {
    CAPTURE(t);
    const Intent at = intent_at(config, 3, t);
    const Pose& X_B = config.waypoints[place].X_BH;
    CHECK_THAT(at.p_B, IsNear(X_B.p, 1e-15));
    CHECK_THAT(to_rotation_vector(at.q_B * conjugate(X_B.q)), IsNear({}, 1e-14));
    CHECK_THAT(at.v_B, IsNear({}, 1e-12));
    CHECK_THAT(at.w_B, IsNear({}, 1e-12));
  };
  for (const double t : {-1.0, 0.0, 0.3, 0.5}) check_at(t, 0);
  for (const double t : {2.5, 2.6, 2.75}) check_at(t, 1);
  for (const double t : {3.75, 4.0, 1e6}) check_at(t, 2);
  // by symmetry half of the way is done after half of the time, on a straight line and about the
  // axis of the whole turn
  const Intent half = intent_at(config, 3, 1.5);
  CHECK_THAT(half.p_B, IsNear({0.1, 0.1, 0}, 1e-15));
  CHECK_THAT(to_rotation_vector(half.q_B), IsNear({0.25, 0, 0}, 1e-14));
  // the peak of minimum jerk: 15/8 of the mean
  CHECK_THAT(half.v_B, IsNear({0, 1.875 * 0.1, 0}, 1e-14));
  CHECK_THAT(half.w_B, IsNear({1.875 * 0.25, 0, 0}, 1e-14));
}

TEST_CASE("waypoints: velocities are the derivatives, without steps", "[device-io]") {
  const IntentConfig config = way();
  constexpr double h = 1e-6;
  Intent before = intent_at(config, 3, 0);
  for (double t = 1e-3; t < 4; t += 1e-3) {
    CAPTURE(t);
    const Intent at = intent_at(config, 3, t);
    const Intent left = intent_at(config, 3, t - h), right = intent_at(config, 3, t + h);
    // third derivative at most 60 · 0.2 m/1 s³, and a step of it at a waypoint
    REQUIRE_THAT(at.v_B, IsNear((right.p_B - left.p_B) / (2 * h), 1e-8));
    REQUIRE_THAT(at.w_B,
                 IsNear(to_rotation_vector(right.q_B * conjugate(left.q_B)) / (2 * h), 1e-8));
    // peak accelerations are 5.8 times 0.15 m and 1.2 rad over 1 s²
    REQUIRE(norm(at.v_B - before.v_B) < 1e-3 * 1);
    REQUIRE(norm(at.w_B - before.w_B) < 1e-3 * 8);
    before = at;
  }
}

TEST_CASE("waypoints: with the tremor of a hand, the same for a seed", "[device-io]") {
  IntentConfig config = way();
  config.tremor_amplitude = 1e-4;
  double most = 0;
  for (double t = 0; t < 4; t += 0.01) {
    const Intent shaken = intent_at(config, 5, t), calm = intent_at(way(), 5, t);
    most = std::max(most, norm(shaken.p_B - calm.p_B));
    CHECK(shaken.q_B == calm.q_B);
    CHECK(shaken.p_B == intent_at(config, 5, t).p_B);
  }
  CHECK(most <= 1e-4);
  CHECK(most > 0.5e-4);
}
