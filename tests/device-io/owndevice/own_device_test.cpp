// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a device behind its vendor's SDK, on virtual time and by its bytes.
#include "device-io/owndevice/own_device.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/impedance.h"
#include "tests/support/emulated_arm.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr int64_t kMs = 1'000'000;

/// A typical hand that keeps a turned handle aside of the middle.
EmulatedDeviceOptions held() {
  EmulatedDeviceOptions options;
  options.arm = &own_device_arm();
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand("typical"), options.hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {0.03, 0.05, -0.02};
  intent.hover_radius = intent.press_radius = intent.stroke_angle = intent.tremor_amplitude = 0;
  intent.turn_angle = 0.8;
  return options;
}

struct Bench {
  test::EmulatedArm<OwnDevice> device;
  DeviceState state{};
  int tick = 0;

  explicit Bench(double max_force = 20, double max_torque = 0.4)
      : device(held(), config(max_force, max_torque)) {}
  static DeviceConfig config(double max_force, double max_torque) {
    DeviceConfig config;
    config.max_force = max_force;
    config.max_torque = max_torque;
    config.serial.max_current = 0.001;  // has no meaning here
    return config;
  }
  void run(int ticks, const Wrench& F_B) {
    for (int i = 0; i < ticks; ++i) {
      const int64_t t_ns = (1000 + tick++) * kMs;
      device.read({t_ns, t_ns}, state);
      device.write(F_B);
    }
  }
  bool has(uint32_t flag) const { return (state.flags & flag) != 0; }
};

}  // namespace

TEST_CASE("own device: the numbers of the line mean what its page says", "[device-io]") {
  // by hand from docs/your-own-device.md
  const Arm& arm = own_device_arm();
  const Pose X = arm.pose(arm.angles({12'345, -20'000, 7, 0, 0, 157'080}));
  CHECK_THAT(X.p, IsNear({0.012345, -0.02, 7e-6}, 1e-12));
  CHECK_THAT(rotate(X.q, {1, 0, 0}), IsNear({0, 1, 0}, 1e-5));
  const MotorAmperes a = arm.currents({}, {{1, -2, 30}, {0.1, -0.6, 0}});
  const std::array<double, 6> thousandths{200, -400, 6000, 1000, -6000, 0};
  for (size_t i = 0; i < 6; ++i) CHECK(1000 * a[i] == Approx(thousandths[i]));
  CHECK(arm.model == 7);
}

TEST_CASE("own device: poses and wrenches go there and back", "[device-io]") {
  const Arm& arm = own_device_arm();
  std::minstd_rand random{1};
  std::uniform_real_distribution<double> one(-1, 1);
  const auto draw = [&] { return Vec3{one(random), one(random), one(random)}; };
  for (int i = 0; i < 2000; ++i) {
    const Pose X{0.5 * draw(), from_rotation_vector(1.7 * draw())};
    JointAngles q;
    REQUIRE(arm.solve(X, q));
    const Pose back = arm.pose(q);
    REQUIRE(norm(back.p - X.p) < 1e-9);
    REQUIRE(norm(to_rotation_vector(back.q * conjugate(X.q))) < 1e-9);
    // through whole counts: half a tick of each at most
    const Pose counted = arm.pose(arm.angles(arm.counts(q)));
    REQUIRE(norm(counted.p - X.p) < 1.8e-6);
    REQUIRE(norm(to_rotation_vector(counted.q * conjugate(X.q))) < 1.8e-5);
    const Wrench F{20 * draw(), 0.4 * draw()};
    const Wrench felt = arm.wrench(q, arm.currents(q, F));
    REQUIRE(norm(felt.f - F.f) < 1e-12);
    REQUIRE(norm(felt.t - F.t) < 1e-12);
  }
}

TEST_CASE("own device: the hand gets the wrench, and no limit of currents counts", "[device-io]") {
  Bench b;
  const Wrench F{{1, -2, 3}, {0.05, 0.02, -0.1}};
  b.run(100, F);
  CHECK_FALSE(b.has(kDeviceSaturated | kDeviceLost | kDeviceStale | kDeviceNoisy));
  CHECK_THAT(b.device.board().record().force_B, IsNear(F.f, 2.5e-3));
  CHECK_THAT(b.device.board().record().torque_B, IsNear(F.t, 5e-5));
  // of the device, and of the line
  b.run(20, {{0, 0, 50}, {0, 0, 3}});
  CHECK(b.has(kDeviceSaturated));
  CHECK(norm(b.device.board().record().force_B) == Approx(20));
  CHECK(norm(b.device.board().record().torque_B) == Approx(0.4));
  Bench strong(1000, 1000);
  CHECK(strong.device.caps().max_force == 30);
  CHECK(strong.device.caps().max_torque == 0.6);
}

TEST_CASE("own device: one that lies is found", "[device-io]") {
  const auto [fault, flag] =
      GENERATE(table<EmulatorFault, uint32_t>({{EmulatorFault::kFrozen, kDeviceStale},
                                               {EmulatorFault::kOldFirst, kDeviceStale},
                                               {EmulatorFault::kDelayed, kDeviceStale}}));
  CAPTURE(static_cast<int>(fault));
  Bench b;
  b.run(1500, {});
  CHECK_FALSE(b.has(kDeviceNoisy | kDeviceStale));
  b.device.board().lie(fault);
  int ticks = 0;
  for (; ticks < 100 && !b.has(flag); ++ticks) b.run(1, {});
  CHECK(ticks < 100);
}

TEST_CASE("own device: a pose that trembles is found, by place or by turn", "[device-io]") {
  const bool turns = GENERATE(false, true);
  // 1 mm and 30 mrad to and fro in each tick: 1000 m/s² and 30,000 rad/s²
  MotorCounts off{};
  off[turns ? 4 : 1] = turns ? 3000 : 1000;
  Bench b;
  b.run(500, {});
  int ticks = 0;
  for (; ticks < 100 && !b.has(kDeviceNoisy); ++ticks) {
    b.device.board().disturb(ticks % 2 == 0 ? off : MotorCounts{}, 1'000'000);
    b.run(1, {});
  }
  CHECK(ticks < 100);
}

TEST_CASE("own device: buttons stand in the first number, and those that cannot be are refused",
          "[device-io]") {
  EncoderReply reply;
  reply.model = 7 + 256 * 5;
  CHECK(model_of(reply) == 7);
  CHECK(buttons_of(reply) == 5);
  int ends[2];
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) == 0);
  const FileDescriptor wire(ends[0]);
  const auto say = [&](const std::string& text) {
    REQUIRE(write(wire.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  };
  say("[7,100,200,300,0,0,0,0]\n");
  OwnDevice device(Bench::config(20, 0.4), FileDescriptor(ends[1]));
  DeviceState state{};
  int64_t t_ns = 1000 * kMs;
  const auto tick = [&](const std::string& answer) {
    device.read({t_ns, t_ns}, state);
    device.write({});
    say(answer);
    t_ns += kMs;
  };
  for (int i = 0; i < 5; ++i) tick("[1287,101,200,300,0,0,0,0]\n");
  CHECK(state.buttons == 5);
  for (int i = 0; i < 3; ++i) tick("[7,101,200,300,0,0,0,0]\n");
  CHECK(state.buttons == 0);
  // a ninth button, and none that a WoodenHaptics has
  const uint64_t before = device.rejected();
  for (int i = 0; i < 3; ++i) tick("[65543,101,200,300,0,0,0,0]\n");
  CHECK(device.rejected() > before);
  CHECK(state.buttons == 0);
  // lost with a button pressed
  for (int i = 0; i < 5; ++i) tick("[263,101,200,300,0,0,0,0]\n");
  REQUIRE(state.buttons == 1);
  for (int i = 0; i < 30; ++i) tick("");
  CHECK((state.flags & kDeviceLost) != 0);
  CHECK(state.buttons == 0);
}
