// SPDX-License-Identifier: GPL-3.0-or-later
// Devices on lines whose encoder counts the wrong way: honest to the protocol, so that no driver
// can tell; the limits hold all the same.
#include <catch2/catch.hpp>

#include "device-io/owndevice/own_device.h"
#include "device-io/polhem/polhem.h"
#include "device-io/sixmotors/six_motors.h"
#include "device-io/woodenhaptics/woodenhaptics.h"
#include "tests/support/driver/rows.h"
#include "tests/support/emulated_arm.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kMost = 3;         // of the config [N]
constexpr double kRounding = 1.02;  // of whole numbers of current

/// An arm whose encoder `Wrong` is wired the other way round; its driver does not know.
template <const Arm& (*honest)(), size_t Wrong>
const Arm& miswired() {
  static const Arm kArm = [] {
    Arm arm = honest();
    arm.counts = [](const JointAngles& q) {
      MotorCounts n = honest().counts(q);
      n[Wrong] = -n[Wrong];
      return n;
    };
    return arm;
  }();
  return kArm;
}

/// Largest force at the handle in three seconds of a typical hand that presses 2 cm deep [N].
template <typename Driver, const Arm& (*arm)()>
double strongest(const DriverRow& row) {
  DeviceConfig config;
  config.max_force = kMost;
  const SimulatedHandConfig hand = pressing(row, "typical", row.wall.depth);
  Wall w(row, open_line<Driver, arm>(hand, config));
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    w.read();
    w.bench->write({w.wall_force() * row.wall.out_B, {}});
    most = std::max(most, norm(w.bench->felt_B().f));
  }
  CHECK(is_finite(w.state.X_BH.p));
  return most;
}

/// The force is bounded at the pose that the driver believes; at the true one it is bounded by the
/// motors, which is how a wrong sign differs from a strong force.
template <typename Driver, const Arm& (*honest)(), size_t... Wrong>
void check_bounded(const char* name) {
  CAPTURE(name);
  CHECK(strongest<Driver, honest>(driver_row(name)) <= kMost * kRounding);
  for (const double wrong : {strongest<Driver, &miswired<honest, Wrong>>(driver_row(name))...}) {
    CHECK(wrong <= 2 * kMost * kRounding);
  }
}

}  // namespace

TEST_CASE("lying device: an encoder of a line that counts backwards drives nothing beyond limits",
          "[device-io]") {
  check_bounded<WoodenHaptics, &woodenhaptics_arm, 0, 1, 2>("woodenhaptics");
  check_bounded<Polhem, &polhem_arm, 1, 2>("polhem");
  check_bounded<SixMotors, &six_motors_arm, 1, 2, 5>("six motors");
  check_bounded<OwnDevice, &own_device_arm, 2, 5>("own device");
}
