// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a device behind its vendor's SDK. tests/device-io/driver tests what all drivers
// share.
#include "device-io/owndevice/own_device_arm.h"

#include <catch2/catch.hpp>

#include "proto/math/units.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/rows.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("own device: the numbers of the line mean what its page says", "[device-io]") {
  // by hand from docs/your-own-device.md
  const Arm& arm = own_device_arm();
  const Pose X = arm.pose(arm.angles({12'345, -20'000, 7, 0, 0, 157'080}));
  CHECK_THAT(X.p, IsNear({0.012345, -0.02, 7e-6}, 1e-12));
  CHECK_THAT(rotate(X.q, {1, 0, 0}), IsNear({0, 1, 0}, 1e-5));
  MotorEfforts a;
  REQUIRE(arm.efforts({}, {}, {{1, -2, 30}, {0.1, -0.6, 0}}, a));
  const std::array<double, 6> thousandths{200, -400, 6000, 1000, -6000, 0};
  for (size_t i = 0; i < 6; ++i) CHECK(1000 * a[i] == Approx(thousandths[i]));
  CHECK(arm.model == 7);
}

TEST_CASE("own device: no limit of currents counts", "[device-io]") {
  DeviceConfig config;
  config.max_force = 20;
  config.max_torque = 0.4;  // below the device's own 0.6
  config.serial.max_current = 0.001;
  Wall w(driver_row("own device"), holding(driver_row("own device")), config);
  w.also_B = {{0, 0, 50}, {0, 0, 3}};
  w.run(50);
  CHECK(w.has(kDeviceSaturated));
  CHECK(norm(w.bench->felt_B().f) == Approx(20));
  CHECK(norm(w.bench->felt_B().t) == Approx(0.4));
  CHECK(w.as<EmulatedArm>().caps().max_torque == 0.4);
}

TEST_CASE("own device: a pose that trembles is found, by place or by turn", "[device-io]") {
  const bool turns = GENERATE(false, true);
  // 1 mm and 30 mrad to and fro in each tick: 1000 m/s² and 30,000 rad/s²
  MotorCounts off{};
  off[turns ? 4 : 1] = turns ? 3000 : 1000;
  Wall w(driver_row("own device"), holding(driver_row("own device"), 0.8));
  w.stiffness = 0;
  w.run(500);
  CHECK_FALSE(w.has(kDoubt));
  int ticks = 0;
  for (; ticks < 100 && !w.has(kDeviceNoisy); ++ticks) {
    w.as<EmulatedArm>().board().disturb(ticks % 2 == 0 ? off : MotorCounts{}, 1'000'000);
    w.step();
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
  MotorDevice device(own_device_arm(), {}, FileDescriptor(ends[1]));
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
