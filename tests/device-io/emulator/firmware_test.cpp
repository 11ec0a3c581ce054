// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/firmware.h"

#include <catch2/catch.hpp>
#include <string>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/impedance.h"
#include "proto/math/units.h"
#include "tests/support/near.h"
#include "tests/support/tip.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tip_at;

namespace {

const Arm& kArm = woodenhaptics_arm();

/// An arm in a typical hand that aims at the origin.
EmulatedDeviceOptions still_hand() {
  EmulatedDeviceOptions options;
  put_into_hand(*find_hand("typical"), options.hand);
  options.hand.intent.direction_B = {0, 0, 1};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = options.hand.intent.tremor_amplitude = 0;
  return options;
}

/// Sends a text at once and runs the loop until it has no more output.
std::string tell(EmulatedDevice& device, std::string_view text, int64_t t_ns) {
  device.receive({text.data(), text.size()});
  std::string said;
  for (int i = 0; i < 20; ++i) {
    device.turn(t_ns);
    said += device.answer();
  }
  return said;
}

}  // namespace

TEST_CASE("emulator: a button is told with the model, and a hand that is led goes there",
          "[device-io]") {
  EmulatedDevice device(still_hand(), 0);
  CHECK(tell(device, "[0,0,0]\n", 1 * kMs).starts_with("[3,"));
  device.press(1);
  device.lead(Vec3{0, 0, 5e-3});
  for (int64_t t = 2; t < 2000; ++t) device.turn(t * kMs);
  CHECK(tell(device, "[0,0,0]\n", 2000 * kMs).starts_with("[259,"));
  CHECK_THAT(device.plant().p_B, IsNear({0, 0, 5e-3}, 1e-3));
  device.press(0);
  device.lead({});
  for (int64_t t = 2001; t < 4000; ++t) device.turn(t * kMs);
  CHECK(tell(device, "[0,0,0]\n", 4000 * kMs).starts_with("[3,"));
  CHECK_THAT(device.plant().p_B, IsNear({}, 1e-3));
}

TEST_CASE("emulator: the motors are off 100 ms after the last good line, and it is counted",
          "[device-io]") {
  EmulatedDevice device(still_hand(), 0);
  tell(device, "[100,200,-300]\n", 5 * kMs);
  CHECK(device.record().currents == Milliamperes{100, 200, -300});
  CHECK(device.record().motors_on == 1);
  for (int64_t t = 6; t < 105; ++t) device.turn(t * kMs);
  CHECK(device.record().currents == Milliamperes{100, 200, -300});
  CHECK(device.record().watchdog == 0);
  CHECK(device.turn(105 * kMs));
  CHECK(device.record().event == EmulatorEvent::kWatchdog);
  CHECK(device.record().currents == Milliamperes{});
  CHECK(device.record().force_B == Vec3{});
  CHECK(device.record().watchdog == 1);
  // once, not in each turn
  for (int64_t t = 106; t < 300; ++t) device.turn(t * kMs);
  CHECK(device.record().watchdog == 1);
  // a dropped line does not enable the motors, a valid one does
  tell(device, "[1,2]\n", 301 * kMs);
  CHECK(device.record().motors_on == 0);
  tell(device, "[4,5,6]\n", 302 * kMs);
  CHECK(device.record().currents == Milliamperes{4, 5, 6});
}

TEST_CASE("emulator: a disturbed answer is off by what was asked for, as often, and is recorded",
          "[device-io]") {
  EmulatedDevice device(still_hand(), 0);
  tell(device, "[0,0,0]\n", 1 * kMs);
  tell(device, "[0,0,0]\n", 2 * kMs);
  const MotorCounts honest = device.record().answered;
  device.disturb(kJumpCounts, 1);
  const std::string said = tell(device, "[0,0,0]\n", 3 * kMs);
  CHECK(said.find("[3," + std::to_string(honest[0] + kJumpCounts[0]) + "," +
                  std::to_string(honest[1] + kJumpCounts[1]) + ",") == 0);
  tell(device, "[0,0,0]\n", 4 * kMs);
  const MotorCounts lied = device.record().answered;
  tell(device, "[0,0,0]\n", 5 * kMs);
  CHECK(device.record().answered == honest);
  // the largest reach of this arm
  const Vec3 way = tip_at(lied) - tip_at(honest);
  CHECK(norm(way) == Approx(0.67).margin(0.001));
  CHECK(norm(device.plant().p_B) < 1e-3);
}

TEST_CASE("emulator: the watchdog keeps its instant when the emulator itself is held up",
          "[device-io]") {
  EmulatedDevice device(still_hand(), 0);
  tell(device, "[0,0,500]\n", 10 * kMs);
  CHECK(device.turn(700 * kMs));
  CHECK(device.record().event == EmulatorEvent::kWatchdog);
  CHECK(device.record().t_ns == 110 * kMs);
}

TEST_CASE("emulator: of lines that waited for it, it obeys the last at most", "[device-io]") {
  const int forces = GENERATE(range(1, 6)), zeros = GENERATE(range(1, 6));
  CAPTURE(forces, zeros);
  std::string waiting;
  for (int i = 0; i < forces; ++i) waiting += "[500,0,0]\n";
  for (int i = 0; i < zeros; ++i) waiting += kZeroCommand;
  EmulatedDevice device(still_hand(), 0);
  device.receive({waiting.data(), waiting.size()});
  for (int i = 0; i < 20; ++i) {
    device.turn(kMs);
    REQUIRE(device.record().currents == Milliamperes{});
  }
}

TEST_CASE("emulator: a torn line makes the firmware drop the next, not the one after",
          "[device-io]") {
  EmulatedDevice device(still_hand(), 0);
  tell(device, "[3000,-20", kMs);
  tell(device, kZeroCommand, 2 * kMs);
  CHECK(device.record().rejected == 1);
  tell(device, kZeroCommand, 3 * kMs);
  CHECK(device.record().commands == 1);
}

TEST_CASE("emulator: the arm gives way to the motors as the hand lets it", "[device-io]") {
  EmulatedDeviceOptions options = still_hand();
  options.hand.coulomb_friction = 0;
  EmulatedDevice device(options, 0);
  JointAngles q{};
  REQUIRE(kArm.solve({}, q));
  MotorEfforts amperes;
  REQUIRE(kArm.efforts(q, {}, {{0, 0, 1.5}, {}}, amperes));
  Milliamperes currents;
  for (size_t i = 0; i < currents.size(); ++i) {
    currents[i] = static_cast<int32_t>(std::lround(1000 * amperes[i]));
  }
  const CommandText command = encode_currents(currents);
  for (int64_t t = 1; t < 3000; ++t) tell(device, command.view(), t * kMs);
  // 1.5 N against 300 N/m; the motors' force turns with the arm by 5 mm / 0.2 m
  const double pushed = device.record().force_B.z / 300;
  CHECK(device.plant().p_B.z == Approx(pushed).epsilon(1e-3));
  CHECK(pushed == Approx(1.5 / 300).epsilon(0.05));
}

TEST_CASE("emulator: encoders answer with whole counts of the joints", "[device-io]") {
  EmulatedDeviceOptions options = still_hand();
  options.hand.intent.centre_B = {0.03, -0.02, 0.05};
  EmulatedDevice device(options, 0);
  tell(device, kZeroCommand, kMs);
  JointAngles q{};
  REQUIRE(kArm.solve({{0.03, -0.02, 0.05}, {}}, q));
  CHECK(device.record().counts == kArm.counts(q));
  // within the three steps of the encoders, each at most 2π/24000 · 0.3 m
  CHECK_THAT(tip_at(device.record().counts), IsNear({0.03, -0.02, 0.05}, 150e-6));
  ReplyReader reader;
  EncoderReply reply;
  bool found = false;
  for (const char c : tell(device, kZeroCommand, 2 * kMs)) found |= reader.push(c, reply);
  REQUIRE(found);
  CHECK(reply.model == 3);
  CHECK(MotorCounts{reply.counts[0], reply.counts[1], reply.counts[2]} == device.record().counts);
}

TEST_CASE("emulator: before its button is pressed it invents a motion and drives no motor",
          "[device-io]") {
  EmulatedDeviceOptions options = still_hand();
  options.button_ns = 50 * kMs;
  EmulatedDevice device(options, 0);
  CHECK(tell(device, "[123,5,6]\n", kMs).rfind("[3,8000,123,", 0) == 0);
  CHECK(device.record().currents == Milliamperes{});
  CHECK(device.record().motors_on == 0);
  device.turn(60 * kMs);
  CHECK(device.record().event == EmulatorEvent::kCalibrated);
  tell(device, "[123,5,6]\n", 61 * kMs);
  CHECK(device.record().currents == Milliamperes{123, 5, 6});
}

TEST_CASE("emulator: five hands, each stiffer than the one before", "[device-io]") {
  double last = -1;
  for (const HandImpedance& hand : kHandImpedances) {
    EmulatedDeviceOptions options = still_hand();
    put_into_hand(hand, options.hand);
    CHECK(options.hand.hand_stiffness > last);
    last = options.hand.hand_stiffness;
    CHECK(find_hand(hand.name) == &hand);
  }
  CHECK(find_hand("iron") == nullptr);
}
