// SPDX-License-Identifier: GPL-3.0-or-later
// A WoodenHaptics that is honest and hardly moves, or whose servo is held up, is no lying one.
#include <catch2/catch.hpp>

#include "proto/math/units.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/rows.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("lying device: a clamped handle at full force is no fault", "[device-io]") {
  // no motion reaches a count: the encoders are constant for ten minutes
  const DriverRow& row = driver_row("woodenhaptics");
  SimulatedHandConfig clamped = pressing(row, "stiff-arm", 0.0095);
  clamped.hand_stiffness = 1e6;
  clamped.intent.tremor_amplitude = 0;
  Wall w(row, clamped);
  EmulatedDevice& board = w.as<EmulatedArm>().board();
  w.run(1000);
  REQUIRE(w.bench->effort() > 800);
  const MotorCounts held = board.record().counts;
  // ten minutes are 600,000 ticks: HAPTIC_TORTURE_SCALE=30
  const auto ticks = static_cast<int>(test::sweep(20'000));
  bool moved = false;
  for (int i = 0; i < ticks; ++i) {
    w.step();
    moved |= board.record().counts != held;
  }
  CHECK_FALSE(moved);
  CHECK((w.seen & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.bench->effort() > 800);
}

TEST_CASE("lying device: a servo that is held up, and lines of hapticd meanwhile, are no lie",
          "[device-io]") {
  Wall w(driver_row("woodenhaptics"));
  for (int round = 0; round < 300; ++round) {
    w.run(1 + round % 7);
    // up to four, some of which overtake each other in the queue
    for (int i = 0; i < round % 5; ++i) {
      w.bench->tell(kZeroCommand);
      if (round % 2 == 0) w.bench->pass(w.t_ns + (1 + i) * kMs);
    }
    w.t_ns += (6 + round % 90) * kMs;
  }
  CHECK((w.seen & kDoubt) == 0);
  w.run(100);
  CHECK_FALSE(w.has(kDoubt | kDeviceLost));
  CHECK(w.is_working());
}
