// SPDX-License-Identifier: GPL-3.0-or-later
// Devices on lines whose encoder counts the wrong way: honest to the protocol, so that no driver
// can tell; the limits hold all the same.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <utility>

#include "device-io/hand/impedance.h"
#include "device-io/owndevice/own_device.h"
#include "device-io/sixmotors/six_motors.h"
#include "device-io/woodenhaptics/woodenhaptics.h"
#include "tests/support/emulated_arm.h"

using namespace haptic;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr double kStiffness = 500;  // of a wall at z = 0 [N/m]
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
template <typename Driver>
double strongest(const Arm& arm, DeviceState& state) {
  EmulatedDeviceOptions options;
  options.arm = &arm;
  options.hand.mass = 0.2;
  options.hand.damping = 0.5;
  options.hand.coulomb_friction = 0.2;
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand("typical"), options.hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {0, 0, -0.02};
  intent.direction_B = {0, 0, 1};
  intent.hover_radius = intent.press_radius = intent.stroke_angle = 0;
  DeviceConfig config;
  config.max_force = 3;
  test::EmulatedArm<Driver> device(options, config);
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    const int64_t t_ns = (1000 + i) * kMs;
    device.read({t_ns, t_ns}, state);
    device.write({{0, 0, -kStiffness * std::min(0.0, state.X_BH.p.z)}, {}});
    most = std::max(most, norm(device.board().record().force_B));
  }
  return most;
}

/// The force is bounded at the pose that the driver believes; at the true one it is bounded by the
/// motors, which is how a wrong sign differs from a strong force.
template <typename Driver, const Arm& (*honest)(), size_t Wrong>
void check_bounded() {
  DeviceState state{};
  const double right = strongest<Driver>(honest(), state);
  CHECK(right <= 3 * kRounding);
  const double wrong = strongest<Driver>(miswired<honest, Wrong>(), state);
  CAPTURE(Wrong, right, wrong);
  CHECK(std::isfinite(norm(state.X_BH.p)));
  CHECK(wrong <= 2 * 3 * kRounding);
}

}  // namespace

TEST_CASE("lying device: an encoder of a line that counts backwards drives nothing beyond limits",
          "[device-io]") {
  SECTION("WoodenHaptics") {
    check_bounded<WoodenHaptics, &woodenhaptics_arm, 0>();
    check_bounded<WoodenHaptics, &woodenhaptics_arm, 1>();
    check_bounded<WoodenHaptics, &woodenhaptics_arm, 2>();
  }
  SECTION("six motors") {
    check_bounded<SixMotors, &six_motors_arm, 1>();
    check_bounded<SixMotors, &six_motors_arm, 2>();
    check_bounded<SixMotors, &six_motors_arm, 5>();
  }
  SECTION("a device of your own") {
    check_bounded<OwnDevice, &own_device_arm, 2>();
    check_bounded<OwnDevice, &own_device_arm, 5>();
  }
}
