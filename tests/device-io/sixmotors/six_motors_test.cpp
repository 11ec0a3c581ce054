// SPDX-License-Identifier: GPL-3.0-or-later
// The driver and the board of six motors on virtual time, known to each other by their bytes.
#include "device-io/sixmotors/six_motors.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/impedance.h"
#include "tests/support/emulated_arm.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;
using EmulatedSixMotors = haptic::test::EmulatedArm<SixMotors>;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStart = 1'000 * kMs;  // of the ticks
const SixMotorsGeometry kDevice;

/// A typical hand that keeps a turned handle aside of the middle, and with `turn` turns it about.
EmulatedDeviceOptions held_still(double turn = 0) {
  EmulatedDeviceOptions options;
  options.arm = &six_motors_arm();
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand("typical"), options.hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {0.03, 0.05, -0.02};
  intent.direction_B = {0, 0, 1};
  intent.hover_radius = intent.press_radius = intent.stroke_angle = intent.tremor_amplitude = 0;
  intent.turn_angle = turn;
  return options;
}

DeviceConfig six_motors_config() {
  DeviceConfig config;
  config.max_force = 5;
  config.max_torque = 0.3;
  return config;
}

struct Bench {
  EmulatedSixMotors device;
  DeviceState state{};
  int tick = 0;

  explicit Bench(const EmulatedDeviceOptions& options = held_still(),
                 const DeviceConfig& config = six_motors_config())
      : device(options, config) {}

  void step(const Wrench& F_B) {
    const int64_t t_ns = kStart + tick++ * kMs;
    device.read({t_ns, t_ns}, state);
    device.write(F_B);
  }
  void run(int ticks, const Wrench& F_B) {
    for (int i = 0; i < ticks; ++i) step(F_B);
  }
  bool has(uint32_t flag) const { return (state.flags & flag) != 0; }
  const EmulatorRecord& record() { return device.board().record(); }
};

/// What half a milliampere in each motor makes at the handle at most: the column sums of J⁻ᵀ, from
/// the numbers of the description alone: 0.2 m of lever for the arm, the wrist's ratios.
constexpr double kForceStep = 5e-3;   // [N]
constexpr double kTorqueStep = 2e-4;  // [N·m]

}  // namespace

TEST_CASE("six motors driver: the hand gets the wrench, within a milliampere", "[device-io]") {
  const Wrench F_B = GENERATE(Wrench{{1, -2, 0.5}, {0.05, -0.08, 0.1}}, Wrench{{}, {0.1, 0, 0}},
                              Wrench{{}, {0, 0.1, 0}}, Wrench{{}, {0, 0, -0.1}},
                              Wrench{{0, 0, 2}, {}}, Wrench{{-2, 0, 0}, {0, 0, 0.02}});
  Bench b;
  b.run(2000, F_B);
  CHECK_FALSE(b.has(kDeviceSaturated | kDeviceLost | kDeviceStale | kDeviceNoisy));
  CHECK(b.has(kDeviceFresh));
  // by the board's own joint angles, which the driver knows to a count
  CHECK(norm(b.record().force_B - F_B.f) <= tol(kForceStep + 2e-3 * norm(F_B.f)));
  CHECK(norm(b.record().torque_B - F_B.t) <= tol(kTorqueStep + 2e-3 * norm(F_B.t)));
  // the hand gives way by its springs, 300 N/m and 2 N·m/rad, but for the friction of the device
  const HandPlant& plant = b.device.board().plant();
  CHECK(norm(300 * (plant.p_B - plant.intent_B) - F_B.f) <= tol(0.05 * std::sqrt(3.0) + 1e-2));
  CHECK(norm(2 * to_rotation_vector(plant.q_B * conjugate(plant.intent_q_B)) - F_B.t) <=
        tol(5e-4 + kTorqueStep + 2e-3 * norm(F_B.t)));
}

TEST_CASE("six motors driver: pose and velocity follow a hand that turns", "[device-io]") {
  Bench b(held_still(0.8));
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    const HandPlant before = b.device.board().plant();
    b.step({});
    if (i < 100) continue;
    REQUIRE(b.has(kDeviceFresh));
    // a tick old, and two counts
    const double speed = norm(before.w_B);
    const Quat off = b.state.X_BH.q * conjugate(before.q_B);
    REQUIRE(norm(to_rotation_vector(off)) < 1e-3 + 2.5e-3 * speed);
    REQUIRE(norm(b.state.X_BH.p - before.p_B) < 3e-4);
    // a count each in a tick is 0.4 rad/s, through the pole of 1.6 ms; and it lags behind
    REQUIRE(norm(b.state.V_BH.w - before.w_B) < 0.5 + 0.2 * speed);
    fastest = std::max(fastest, speed);
  }
  CHECK(fastest > 1.5);
}

TEST_CASE("six motors driver: force and torque beyond the device are shortened, not turned",
          "[device-io]") {
  Bench b;
  b.run(50, {{0, 0, 50}, {}});
  CHECK(b.has(kDeviceSaturated));
  CHECK(norm(b.record().force_B) == Approx(5).epsilon(0.01));
  b.run(50, {{1, 0, 0}, {0, 3, 0}});
  CHECK(b.has(kDeviceSaturated));
  CHECK_THAT(b.record().torque_B, IsNear({0, 0.3, 0}, 5e-3));
  CHECK_THAT(b.record().force_B, IsNear({1, 0, 0}, 5e-2));
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  b.run(3, {{1, 0, 0}, {0, 0, bad}});
  CHECK(b.has(kDeviceSaturated));
  b.step({});
  CHECK(b.record().currents == Milliamperes{});

  DeviceConfig weak = six_motors_config();
  weak.serial.max_current = 0.5;
  Bench w(held_still(), weak);
  w.run(50, {{0, 0, 2}, {0, 0.15, 0}});
  CHECK(w.has(kDeviceSaturated));
  int32_t most = 0;
  for (const int32_t mA : w.record().currents) most = std::max(most, std::abs(mA));
  CHECK(most == 500);
  // the same share of both
  const Wrench felt{w.record().force_B, w.record().torque_B};
  CHECK(felt.f.z / 2 == Approx(felt.t.y / 0.15).epsilon(0.02));
}

TEST_CASE("six motors driver: without max_torque it is a device that feels no torque",
          "[device-io]") {
  DeviceConfig config;
  config.max_force = 5;
  Bench b(held_still(), config);
  CHECK(b.device.caps().max_torque == 0);
  CHECK(b.device.caps().max_force == 5);
  b.run(20, {{0, 0, 1}, {0, 0.1, 0}});
  CHECK(norm(b.record().torque_B) <= tol(kTorqueStep));
}

TEST_CASE("six motors driver: a jump of the wrist is a jump of the pose, once or for ever",
          "[device-io]") {
  Bench b;
  b.run(100, {});
  const Quat before = b.state.X_BH.q;
  const auto turned = [&] { return norm(to_rotation_vector(b.state.X_BH.q * conjugate(before))); };
  b.device.board().disturb(kTurnJumpCounts, 1);
  double most = 0;
  int far = 0;
  for (int i = 0; i < 5; ++i) {
    b.step({});
    most = std::max(most, turned());
    far += turned() > 0.5;
  }
  CHECK(most == Approx(1).epsilon(1e-3));
  CHECK(far == 1);
  b.device.board().disturb(kTurnJumpCounts, std::numeric_limits<uint64_t>::max());
  b.run(50, {});
  CHECK(turned() == Approx(1).epsilon(1e-3));
  b.device.board().disturb({}, 0);
  b.run(3, {});
  CHECK(turned() < 1e-3);
}

TEST_CASE("six motors driver: a noisy wrist and a lying board are found", "[device-io]") {
  const auto [fault, flag] =
      GENERATE(table<EmulatorFault, uint32_t>({{EmulatorFault::kTurnNoise, kDeviceNoisy},
                                               {EmulatorFault::kFrozen, kDeviceStale},
                                               {EmulatorFault::kOldFirst, kDeviceStale},
                                               {EmulatorFault::kDelayed, kDeviceStale}}));
  CAPTURE(static_cast<int>(fault));
  Bench b;
  b.run(1500, {});
  CHECK_FALSE(b.has(kDeviceNoisy | kDeviceStale));
  b.device.board().lie(fault);
  int ticks = 0;
  for (; ticks < 100 && !b.has(flag); ++ticks) b.step({});
  CHECK(ticks < 100);
}

TEST_CASE("six motors driver: a hand that turns it hard is no noise", "[device-io]") {
  // the strongest torque to and fro, on a handle that nobody holds
  EmulatedDeviceOptions options = held_still();
  options.hand.inertia = 2e-4;
  put_into_hand(*find_hand("none"), options.hand);
  Bench b(options);
  for (int i = 0; i < 2000; ++i) {
    const double sign = i / 20 % 2 == 0 ? 1 : -1;
    b.step({{}, {0, 0, sign * (i < 10 ? 0.15 : 0.3)}});
    REQUIRE_FALSE(b.has(kDeviceNoisy));
  }
}

TEST_CASE("six motors driver: what lets go of it is a zero for each motor", "[device-io]") {
  Bench b;
  b.run(20, {{0, 0, 1}, {0, 0.1, 0}});
  const DeviceRelease release = b.device.driver().release();
  CHECK(std::string_view(release.bytes.data(), release.size) == "[0,0,0,0,0,0]\n");
  b.run(3, {});
  CHECK(b.record().currents == Milliamperes{});
  // a board that is left alone switches its motors off
  b.run(3, {{0, 0, 1}, {}});
  CHECK(b.record().motors_on == 1);
  b.device.board().turn(kStart + (b.tick + 200) * kMs);
  CHECK(b.record().event == EmulatorEvent::kWatchdog);
  CHECK(b.record().torque_B == Vec3{});
}
