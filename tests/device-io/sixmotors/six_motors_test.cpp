// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a device of six motors: its wrist and its torque. tests/device-io/driver tests what
// all drivers share.
#include "device-io/sixmotors/kinematics.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/impedance.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/rows.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// In this hand, with nothing to feel.
Wall held(const SimulatedHandConfig& hand = holding(driver_row("six motors"))) {
  Wall w(driver_row("six motors"), hand);
  w.stiffness = 0;
  return w;
}

}  // namespace

TEST_CASE("six motors driver: a jump of the wrist is a jump of the pose, once or for ever",
          "[device-io]") {
  Wall w = held();
  auto& board = w.as<EmulatedArm>().board();
  w.run(100);
  const Quat before = w.state.X_BH.q;
  const auto turned = [&] { return norm(to_rotation_vector(w.state.X_BH.q * conjugate(before))); };
  board.disturb(kTurnJumpCounts, 1);
  double most = 0;
  int far = 0;
  for (int i = 0; i < 5; ++i) {
    w.step();
    most = std::max(most, turned());
    far += turned() > 0.5;
  }
  CHECK(most == Approx(1).epsilon(1e-3));
  CHECK(far == 1);
  board.disturb(kTurnJumpCounts, std::numeric_limits<uint64_t>::max());
  w.run(50);
  CHECK(turned() == Approx(1).epsilon(1e-3));
  board.disturb({}, 0);
  w.run(3);
  CHECK(turned() < 1e-3);
}

TEST_CASE("six motors driver: a hand that turns it hard is no noise", "[device-io]") {
  // the strongest torque to and fro, on a handle that nobody holds
  SimulatedHandConfig hand = holding(driver_row("six motors"));
  hand.inertia = 2e-4;
  put_into_hand(*find_hand("none"), hand);
  Wall w = held(hand);
  for (int i = 0; i < 2000; ++i) {
    const double sign = i / 20 % 2 == 0 ? 1 : -1;
    w.read();
    w.bench->write({{}, {0, 0, sign * (i < 10 ? 0.15 : 0.3)}});
    REQUIRE_FALSE(w.has(kDeviceNoisy));
  }
}
