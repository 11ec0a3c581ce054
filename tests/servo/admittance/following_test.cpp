// SPDX-License-Identifier: GPL-3.0-or-later
// An arm that lags behind its commands, and one that is held, on paths that are written out.
#include "servo/admittance/following.h"

#include <cmath>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;

namespace {

/// Moving and turning to and fro: up to 1 m/s and 10 rad/s.
Pose commanded_at(double t) {
  return {{0.1 * std::sin(10 * t), 0.02 * t, 0}, from_rotation_vector({0, 0, std::sin(10 * t)})};
}

/// The first tick in which the arm does not follow; -1: it does for two seconds. `arm_at` says
/// where it is in a tick.
template <class ArmAt>
int unfollowed(ArmAt arm_at, double dt = kTick) {
  CommandedWays commanded;
  const int ticks = static_cast<int>(2 / dt);
  for (int k = 1; k <= ticks; ++k) {
    const Pose last = commanded_at(dt * (k - 1)), now = commanded_at(dt * k);
    note_way(commanded, last, now);
    if (!is_following(commanded, now, arm_at(k), dt)) return k;
  }
  return -1;
}

}  // namespace

TEST_CASE("following: an arm may be late by fifty milliseconds and three ticks", "[servo]") {
  const double dt = GENERATE(1e-2, 1e-3, 1e-4);
  const double most = 0.05 + 3 * dt;
  const auto late_by = [dt](double late) {
    return [=](int k) { return commanded_at(std::max(dt * k - late, 0.0)); };
  };
  CHECK(unfollowed(late_by(0), dt) == -1);
  CHECK(unfollowed(late_by(most), dt) == -1);
  // 20 mrad and 2 mm are gone in less than 2 ms at full speed
  CHECK(unfollowed(late_by(most + 0.02), dt) > 0);
}

TEST_CASE("following: an arm that is held is found when fifty milliseconds have gone by",
          "[servo]") {
  const bool turns = GENERATE(false, true);
  const auto held = [turns](int k) {
    const Pose X = commanded_at(kTick * k);
    return turns ? Pose{X.p, {}} : Pose{{}, X.q};
  };
  const int at = unfollowed(held);
  CAPTURE(turns, at);
  CHECK(at > 53);
  CHECK(at < 60);
}

TEST_CASE("following: it yields two millimetres and twenty milliradians", "[servo]") {
  const CommandedWays none;
  const auto stands_at = [&](const Pose& X) { return is_following(none, {}, X, kTick); };
  CHECK(stands_at({{0, 1.99e-3, 0}, {}}));
  CHECK_FALSE(stands_at({{0, 2.01e-3, 0}, {}}));
  CHECK(stands_at({{}, from_rotation_vector({19.9e-3, 0, 0})}));
  CHECK_FALSE(stands_at({{}, from_rotation_vector({20.1e-3, 0, 0})}));
}
