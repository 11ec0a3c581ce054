// SPDX-License-Identifier: GPL-3.0-or-later
// A device that was written down by `hapt devices try` is played to its driver: the first 0.2 s
// of haptic-emulator, a hand in strokes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/motor_device.h"
#include "tests/support/data.h"
#include "tests/support/usb/device_bytes.h"
#include "tests/support/usb/device_replay.h"

namespace haptic {
namespace {

constexpr int64_t kTickNs = 1'000'000;

std::vector<DeviceBytes> recorded() {
  std::ifstream in(test::from_source("tests/clients/desk/trial/emulated-woody.bytes"));
  return test::read_device_bytes(in);
}

/// The states that the driver made of a recording, tick by tick.
std::vector<DeviceState> played(test::DeviceReplay& replay) {
  MotorDevice driver(woodenhaptics_arm(), {}, replay.driver_end());
  std::vector<DeviceState> states;
  for (int64_t t_ns = kTickNs; t_ns < 300 * kTickNs && !replay.is_over(); t_ns += kTickNs) {
    replay.pass();
    DeviceState state{};
    driver.read({t_ns, t_ns}, state);
    driver.write({});
    states.push_back(state);
  }
  return states;
}

}  // namespace

TEST_CASE("device replay: a recorded device is driven as it was, challenges too") {
  test::DeviceReplay replay(recorded());
  const std::vector<DeviceState> states = played(replay);
  CHECK(replay.is_over());
  CHECK_FALSE(replay.is_mismatched());
  REQUIRE(states.size() > 150);
  for (const DeviceState& state : states) {
    CHECK((state.flags & (kDeviceLost | kDeviceStale | kDeviceNoisy)) == 0);
    CHECK((state.flags & kDeviceHomed) != 0);
  }
  // what the emulator's own log has at the last counts, a tick later at 0.2 m/s
  CHECK(norm(states.back().X_BH.p - Vec3{-0.01184, 0.01511, -0.01463}) < 5e-4);
}

TEST_CASE("device replay: a host that says something else hears no more") {
  std::vector<DeviceBytes> pieces = recorded();
  const auto challenge = std::ranges::find(pieces, "[]\n[0,0,0]\n", &DeviceBytes::bytes);
  REQUIRE(challenge != pieces.end());
  challenge->bytes = "[0,0,0]\n";
  test::DeviceReplay replay(pieces);
  const std::vector<DeviceState> states = played(replay);
  CHECK(replay.is_mismatched());
  CHECK_FALSE(replay.is_over());
  CHECK((states.back().flags & kDeviceLost) != 0);
}

}  // namespace haptic
