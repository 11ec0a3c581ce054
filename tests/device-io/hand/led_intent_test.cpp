// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for device-io/hand/led_intent.cpp, alone and in a simulated hand.
#include "device-io/hand/led_intent.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "device-io/hand/simulated_hand.h"
#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr Intent kAtRest{};

DeviceState read_led(SimulatedHand& hand, int64_t tick) {
  DeviceState state{};
  hand.read({tick * kMs, tick * kMs}, state);
  return state;
}

/// Commands at 60 Hz on a circle that jump by up to 5 mm, over half a second. Returns the largest
/// change of the velocity in a step.
double largest_velocity_step(double h) {
  LedIntent led;
  Vec3 at_B, v_B;
  double largest = 0;
  for (int command = 0; command < 30; ++command) {
    const Vec3 to_B{0.03 * std::cos(0.15 * command) - 0.03, 0.03 * std::sin(0.15 * command), 0};
    retarget(led, Pose{to_B, {}}, kAtRest);
    for (double t = 0; t < 1.0 / 60; t += h) {
      const Vec3 next_B = follow(led, {to_B, {}}, h).p;
      const Vec3 velocity_B = (next_B - at_B) / h;
      largest = std::max(largest, norm(velocity_B - v_B));
      at_B = next_B;
      v_B = velocity_B;
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("led intent: a step is answered as by a critically damped spring", "[device-io]") {
  LedIntent led;
  const Vec3 to_B{0.02, -0.01, 0.005};
  retarget(led, Pose{to_B, {}}, kAtRest);
  const double h = 1e-5;
  double t = 0;
  for (int k = 0; k < 30000; ++k) {
    const Vec3 p_B = follow(led, {to_B, {}}, h).p;
    t += h;
    const double left = (1 + kLedRate * t) * std::exp(-kLedRate * t);
    // first order in the step
    if (k % 1000 == 0) CHECK_THAT(p_B, IsNear((1 - left) * to_B, 5e-6));
  }
}

TEST_CASE("led intent: the velocity has no steps, whatever the commands", "[device-io]") {
  // of a motion that is C¹ the change of the velocity in a step falls with the step
  const double coarse = largest_velocity_step(1e-3), fine = largest_velocity_step(1e-4);
  CHECK(coarse > 1e-3);
  CHECK(fine < 0.15 * coarse);
}

TEST_CASE("led intent: its speed is bounded, and it never overshoots", "[device-io]") {
  LedIntent led;
  const Vec3 to_B{0.3, 0.4, 0};
  retarget(led, Pose{to_B, {}}, kAtRest);
  double fastest = 0, before = 0;
  for (int k = 0; k < 3000; ++k) {
    const double p = dot(follow(led, {to_B, {}}, 1e-3).p, normalized(to_B));
    fastest = std::max(fastest, (p - before) / 1e-3);
    REQUIRE(p >= before);
    REQUIRE(p <= 0.5 + tol(1e-12));
    before = p;
  }
  CHECK(fastest <= kMostLedSpeed * (1 + 1e-9));
  CHECK(fastest > 0.99 * kMostLedSpeed);
  CHECK(before == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("simulated hand: led, it begins and ends without a jump and goes on as configured",
          "[device-io]") {
  DeviceConfig config;
  config.max_torque = 0.3;
  config.hand.inertia = 1e-4;
  config.hand.intent.stroke_time = 1.2;
  config.hand.intent.turn_angle = 0.4;
  SimulatedHand led(config), alone(config);
  const Pose wanted{config.hand.intent.centre_B + Vec3{0, 0.1, 0.02},
                    from_rotation_vector({0.5, 0.2, -2.8})};
  HandPlant before = led.plant();
  Twist velocity;
  double fastest = 0, spinning = 0, jerked = 0, twisted = 0;
  for (int64_t k = 0; k < 6000; ++k) {
    const bool leads = k >= 700 && k < 3000;
    const DeviceState state = read_led(led, k);
    read_led(alone, k);
    led.lead(leads ? std::optional(wanted) : std::nullopt);
    const HandPlant& now = led.plant();
    const Twist v{(now.intent_B - before.intent_B) / 1e-3,
                  to_rotation_vector(now.intent_q_B * conjugate(before.intent_q_B)) / 1e-3};
    if (k > 1) fastest = std::max(fastest, norm(v.v)), spinning = std::max(spinning, norm(v.w));
    if (k > 2) jerked = std::max(jerked, norm(v.v - velocity.v));
    if (k > 2) twisted = std::max(twisted, norm(v.w - velocity.w));
    velocity = v;
    before = now;
    REQUIRE(((state.flags & kDeviceLed) != 0) == (k > 700 && k <= 3000));
    if (k == 2999) {
      CHECK_THAT(now.intent_B, IsNear(wanted.p, 1e-6));
      CHECK_THAT(state.X_BH.p, IsNear(wanted.p, 1e-3));
      CHECK_THAT(to_rotation_vector(now.intent_q_B * conjugate(wanted.q)), IsNear({}, 1e-6));
    }
    // before it is led and once it is back, the intent is its own to the bit
    if (k > 700 && k <= 5500) continue;
    REQUIRE(now.intent_B == alone.plant().intent_B);
    REQUIRE(now.intent_q_B == alone.plant().intent_q_B);
  }
  // its own motion, at most 1.875·0.4/0.6 s of turning, and that of the lead
  CHECK(fastest < kMostLedSpeed + 0.5);
  CHECK(spinning < kMostLedSpin + 1.25);
  CHECK(spinning > 0.9 * kMostLedSpin);
  // a jump of 1 mm would be 1 m/s, one of a tenth of a degree 1.7 rad/s; the filter's acceleration
  // is ω² · 0.15 m and ω² · 3 rad at most, over 1 ms
  CHECK(jerked < kLedRate * kLedRate * 0.15 * 1e-3);
  CHECK(twisted < kLedRate * kLedRate * 3 * 1e-3);
}

TEST_CASE("simulated hand: nobody is led by what is no place, and never out of the workspace",
          "[device-io]") {
  DeviceConfig config;
  config.workspace_centre_B = {0.01, 0, 0};
  config.workspace_radius = 0.15;
  SimulatedHand hand(config), alone(config), far(config);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int64_t k = 0; k < 3000; ++k) {
    read_led(hand, k);
    read_led(alone, k);
    read_led(far, k);
    hand.lead(k % 2 == 0 ? std::nullopt : std::optional(Pose{{nan, 0, 0}, {}}));
    far.lead(Pose{{0.01, 1e6, 0}, {}});
    REQUIRE(hand.plant().p_B == alone.plant().p_B);
    REQUIRE(norm(far.plant().intent_B - config.workspace_centre_B) <= 0.15 + tol(1e-12));
  }
  CHECK_THAT(far.plant().intent_B, IsNear({0.01, 0.15, 0}, 1e-6));
}

TEST_CASE("simulated hand: a device that no hand holds is not led", "[device-io]") {
  DeviceConfig config;
  config.hand.hand_stiffness = config.hand.hand_damping = config.hand.hand_mass = 0;
  SimulatedHand hand(config);
  for (int64_t k = 0; k < 100; ++k) {
    CHECK((read_led(hand, k).flags & kDeviceLed) == 0);
    hand.lead(Pose{{0.1, 0, 0}, {}});
  }
  CHECK(hand.plant().p_B == Vec3{});
}
