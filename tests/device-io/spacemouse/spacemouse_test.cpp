// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a SpaceMouse and an emulated one, on virtual time.
#include "device-io/spacemouse/spacemouse.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "device-io/emulator/emulated_spacemouse.h"
#include "proto/math/units.h"
#include "servo/safety/safety.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kMetresPerSecond = 0.2, kRadiansPerSecond = 1.5;  // the defaults of [device.rate]

struct Bench {
  EmulatedSpaceMouse emulated;
  int64_t t_ns = 1'000 * kMs;
  bool plugged = true;
  SpaceMouse driver;
  DeviceState state{};

  explicit Bench(const EmulatedSpaceMouseOptions& options, const DeviceConfig& config = {})
      : emulated(options), driver(config, "emulated", [this](std::span<uint8_t> report) {
          UsbBytes packet;
          if (!plugged) return -1;
          if (!emulated.give(0x81, report.size(), packet, t_ns)) return 0;
          std::copy(packet.begin(), packet.end(), report.begin());
          return static_cast<int>(packet.size());
        }) {}

  void step() {
    t_ns += kMs;
    driver.read({t_ns, t_ns}, state);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
};

/// These counts for `seconds`, then rest.
EmulatedSpaceMouseOptions pushed(std::array<int, 6> axes, double seconds, bool whole = false) {
  EmulatedSpaceMouseOptions options;
  options.whole = whole;
  options.hand = [=](double t) { return t < seconds ? axes : std::array<int, 6>{}; };
  return options;
}

}  // namespace

TEST_CASE("spacemouse: a full push moves the handle at full speed, in the axes of B",
          "[device-io]") {
  // right, away from the user, up: by the manual's picture of the knob
  struct Row {
    std::array<int, 6> axes;
    Vec3 way_B, turn_B;
  };
  const auto [axes, way_B, turn_B] = GENERATE(
      Row{{350, 0, 0, 0, 0, 0}, {1, 0, 0}, {}}, Row{{0, -350, 0, 0, 0, 0}, {0, 0, -1}, {}},
      Row{{0, 0, -350, 0, 0, 0}, {0, 1, 0}, {}}, Row{{0, 0, 0, 350, 0, 0}, {}, {1, 0, 0}},
      Row{{0, 0, 0, 0, -350, 0}, {}, {0, 0, -1}}, Row{{0, 0, 0, 0, 0, -350}, {}, {0, 1, 0}});
  const bool whole = GENERATE(false, true);
  Bench bench(pushed(axes, 1, whole));
  bench.run(500);
  CHECK_THAT(bench.state.V_BH.v, IsNear(kMetresPerSecond * way_B, 1e-9));
  CHECK_THAT(bench.state.V_BH.w, IsNear(kRadiansPerSecond * turn_B, 1e-9));
  bench.run(1500);
  // it may begin and end up to two reports late
  CHECK_THAT(bench.state.X_BH.p, IsNear(kMetresPerSecond * way_B, 0.033 * kMetresPerSecond));
  CHECK_THAT(to_rotation_vector(bench.state.X_BH.q),
             IsNear(kRadiansPerSecond * turn_B, 0.033 * kRadiansPerSecond));
  CHECK(bench.state.V_BH == Twist{});
  CHECK(bench.driver.rejected() == 0);
}

TEST_CASE("spacemouse: the dead band is free of a step, larger counts are clipped", "[device-io]") {
  struct Row {
    int count;
    double share;
  };
  // (350 · 0.05 = 17.5 counts are none; half of the rest is half of the speed)
  const auto [count, share] = GENERATE(Row{0, 0}, Row{17, 0}, Row{18, 0.5 / 332.5},
                                       Row{-18, -0.5 / 332.5}, Row{184, 166.5 / 332.5}, Row{350, 1},
                                       Row{-350, -1}, Row{420, 1}, Row{-32768, -1}, Row{32767, 1});
  SpaceMouseInput input;
  input.axes[0] = static_cast<int16_t>(count);
  CHECK(commanded_velocity(input, {}).v.x == Approx(kMetresPerSecond * share).margin(1e-12));
}

TEST_CASE("spacemouse: it stays in its workspace, and slides along the edge", "[device-io]") {
  DeviceConfig config;
  config.workspace_centre_B = {0.01, 0.02, 0.03};
  config.workspace_radius = 0.1;
  config.workspace_turn = 0.5;
  Bench bench(pushed({350, 0, 0, 0, 0, -350}, 3), config);
  bench.step();
  CHECK(bench.state.X_BH.p == config.workspace_centre_B);
  bench.run(2000);
  CHECK_THAT(bench.state.X_BH.p, IsNear(Vec3{0.11, 0.02, 0.03}, 1e-9));
  CHECK_THAT(to_rotation_vector(bench.state.X_BH.q), IsNear({0, 0.5, 0}, 1e-9));
  // what the handle does, not what is commanded
  CHECK(norm(bench.state.V_BH.v) < 1e-9);
  CHECK(norm(bench.state.V_BH.w) < 1e-9);
}

TEST_CASE("spacemouse: at rest it is silent for an hour, and not lost", "[device-io]") {
  Bench bench(pushed({100, 0, 0, 0, 0, 0}, 0.5));
  bench.run(1000);
  const Vec3 rests_B = bench.state.X_BH.p;
  const uint64_t reports = bench.emulated.reports();
  bench.t_ns += 3'600'000 * kMs;
  bench.run(1000);
  CHECK(bench.emulated.reports() == reports);
  CHECK(bench.state.X_BH.p == rests_B);
  CHECK((bench.state.flags & (kDeviceLost | kDeviceFresh)) == kDeviceFresh);
}

TEST_CASE("spacemouse: unplugged, it is lost, stands still and is not asked again", "[device-io]") {
  EmulatedSpaceMouseOptions options = pushed({350, 0, 0, 0, 0, 0}, 10);
  options.buttons = [](double) { return 1u; };
  Bench bench(options);
  bench.run(500);
  REQUIRE(bench.state.buttons == 1);
  const Vec3 last_B = bench.state.X_BH.p;
  bench.plugged = false;
  bench.step();
  CHECK((bench.state.flags & kDeviceLost) != 0);
  CHECK(bench.state.buttons == 0);
  bench.plugged = true;
  bench.run(100);
  CHECK((bench.state.flags & kDeviceLost) != 0);
  CHECK(bench.state.X_BH.p == last_B);
}

TEST_CASE("spacemouse: lying device: one that falls silent while deflected comes to rest",
          "[device-io]") {
  Bench bench(pushed({350, 0, 0, 0, 0, 0}, 10));
  bench.run(500);
  const Vec3 before_B = bench.state.X_BH.p;
  bench.emulated.lie(EmulatorFault::kSilent);
  bench.run(2000);
  CHECK(bench.state.V_BH == Twist{});
  // within 0.2 s, so within 42 mm
  CHECK(norm(bench.state.X_BH.p - before_B) < 0.042);
  bench.emulated.lie(EmulatorFault::kHealthy);
  bench.run(20);
  CHECK(norm(bench.state.V_BH.v) == Approx(kMetresPerSecond));
}

TEST_CASE(
    "spacemouse: lying device: whatever it says, the handle is finite, no faster than its "
    "speed, and in its workspace",
    "[device-io]") {
  const auto fault =
      GENERATE(EmulatorFault::kFrozen, EmulatorFault::kDelayed, EmulatorFault::kNoise,
               EmulatorFault::kFlipped, EmulatorFault::kHalves, EmulatorFault::kLoses,
               EmulatorFault::kOverdone);
  DeviceConfig config;
  config.workspace_radius = 0.1;
  EmulatedSpaceMouseOptions options;
  options.hand = [](double t) {
    const int n = static_cast<int>(300 * std::sin(3 * t));
    return std::array<int, 6>{n, -n, n / 2, n / 3, n, -n};
  };
  Bench bench(options, config);
  bench.run(500);
  bench.emulated.lie(fault);
  for (int i = 0; i < 3000; ++i) {
    bench.step();
    REQUIRE(is_finite(bench.state.X_BH));
    REQUIRE(is_unit(bench.state.X_BH.q));
    REQUIRE(norm(bench.state.X_BH.p) <= 0.1 + 1e-12);
    REQUIRE(norm(bench.state.V_BH.v) <= std::sqrt(3.0) * kMetresPerSecond + 1e-9);
  }
  CHECK((bench.driver.rejected() > 0) == (fault == EmulatorFault::kHalves));
}

TEST_CASE("spacemouse: a stalled servo does not make the handle jump", "[device-io]") {
  Bench bench(pushed({350, 0, 0, 0, 0, 0}, 10));
  bench.run(500);
  const double before = bench.state.X_BH.p.x;
  bench.t_ns += 1000 * kMs;
  bench.step();
  CHECK(bench.state.X_BH.p.x - before <= 0.02 * kMetresPerSecond + 1e-12);
}

TEST_CASE("spacemouse: the same reports make the same way, whenever it was started",
          "[device-io]") {
  Bench first(pushed({200, -100, 50, 80, 0, -90}, 0.4));
  Bench second(pushed({200, -100, 50, 80, 0, -90}, 0.4));
  second.t_ns += 8 * 12'345 * kMs;
  first.run(1000);
  second.run(1000);
  CHECK(first.state.X_BH == second.state.X_BH);
}

TEST_CASE("safety: a device without actuators feels no force, and that is no fault", "[servo]") {
  SafetyLimits limits;
  limits.max_force = limits.max_torque = 0;
  SafetyState state;
  SafetyInput input{};
  input.device.flags = kDeviceFresh | kDeviceHomed;
  input.device_finite = input.contacts_finite = true;
  input.armed = true;
  for (int i = 1; i <= 100; ++i) {
    input.now_ns = input.device.t_ns = i * kMs;
    input.F_B = {{0, 5, -900}, {0.1, 0, 0}};
    const SafetyOutput out = make_safe(limits, state, input, 1e-3);
    REQUIRE(out.F_B == Wrench{});
    REQUIRE((out.flags & (kServoFault | kServoSaturated)) == 0);
  }
  CHECK(state.fault == Fault::kNone);
}
