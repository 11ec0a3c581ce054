// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/simulated_hand.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr double kAlgebra = 1e-12;
constexpr int64_t kMs = 1'000'000;

TickTime tick_at(int64_t t_ns) {
  return {t_ns, t_ns};
}

DeviceState read_at(Device& device, int64_t t_ns) {
  DeviceState state{};
  device.read(tick_at(t_ns), state);
  return state;
}

/// A spring to the centre in place of a server.
std::vector<DeviceState> session(uint64_t seed, int ticks) {
  DeviceConfig config;
  config.hand.seed = seed;
  SimulatedHand hand(config);
  std::vector<DeviceState> states;
  for (int k = 0; k < ticks; ++k) {
    states.push_back(read_at(hand, 77 + k * kMs));
    const Vec3& p_B = states.back().X_BH.p;
    hand.write({norm(p_B) < 0.05 ? 800 * (0.05 - norm(p_B)) * normalized(p_B) : Vec3{}, {}});
  }
  return states;
}

bool same_bits(const std::vector<DeviceState>& a, const std::vector<DeviceState>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

}  // namespace

TEST_CASE("simulated hand: one seed gives the same states to the bit, another seed others",
          "[device-io]") {
  const auto first = session(1, 2000);
  CHECK(same_bits(first, session(1, 2000)));
  CHECK_FALSE(same_bits(first, session(2, 2000)));
}

TEST_CASE("simulated hand: it touches what it strokes and is flagged as simulated", "[device-io]") {
  const auto states = session(1, 6000);
  int touching = 0;
  for (const DeviceState& state : states) {
    REQUIRE((state.flags & ~uint32_t{kDeviceSaturated}) ==
            (kDeviceFresh | kDeviceHomed | kDeviceSimulated));
    REQUIRE(state.X_BH.q == Quat{});
    REQUIRE(state.V_BH.w == Vec3{});
    touching += norm(state.X_BH.p) < 0.05 ? 1 : 0;
  }
  CHECK(touching > 1000);
  CHECK(touching < 5000);
}

TEST_CASE("simulated hand: the position is the encoder's step below the true one", "[device-io]") {
  DeviceConfig config;
  config.hand.encoder_step = 1e-4;
  SimulatedHand hand(config);
  for (int k = 0; k < 500; ++k) {
    const Vec3 p_B = read_at(hand, k * kMs).X_BH.p;
    for (int i = 0; i < 3; ++i) {
      const double below = hand.plant().p_B[i] - p_B[i];
      REQUIRE(below >= -tol(kAlgebra));
      REQUIRE(below < 1e-4 + tol(kAlgebra));
      REQUIRE(std::fabs(std::remainder(p_B[i], 1e-4)) <= tol(kAlgebra));
    }
  }
}

TEST_CASE("simulated hand: the velocity follows a ramp after the time constant of its filter",
          "[device-io]") {
  DeviceConfig config;
  config.hand.encoder_step = 0;
  config.hand.coulomb_friction = 0;
  config.hand.hand_stiffness = config.hand.hand_damping = config.hand.hand_mass = 0;
  config.hand.mass = 1;
  config.hand.damping = 0;
  SimulatedHand hand(config);
  // a constant force: v = a t, seen late by the pole and half a period of differencing
  const double a = 0.5, T = 1e-3, pole = 1 / (2 * std::numbers::pi * 100);
  DeviceState state{};
  for (int k = 0; k <= 100; ++k) {
    hand.read(tick_at(k * kMs), state);
    hand.write({{a, 0, 0}, {}});
  }
  // y += T/(T+τ)(u − y) lags a ramp by τ
  CHECK_THAT(state.V_BH.v, IsNear({a * (0.1 - T / 2 - pole), 0, 0}, 1e-6));
  CHECK_THAT(hand.plant().v_B, IsNear({a * 0.1, 0, 0}, 1e-9));
}

TEST_CASE("simulated hand: a force above the limit is shortened and keeps its direction",
          "[device-io]") {
  DeviceConfig config;
  config.max_force = 8;
  SimulatedHand hand(config);
  read_at(hand, 0);
  const Vec3 wanted_B{12, -16, 5};
  hand.write({wanted_B, {}});
  CHECK(norm(hand.held().f) == Approx(8).epsilon(tol(kAlgebra)));
  CHECK_THAT(normalized(hand.held().f), IsNear(normalized(wanted_B), kAlgebra));
  CHECK((read_at(hand, kMs).flags & kDeviceSaturated) != 0);
  hand.write({{3, 0, 4}, {}});
  CHECK(hand.held().f == Vec3{3, 0, 4});
  CHECK((read_at(hand, 2 * kMs).flags & kDeviceSaturated) == 0);
}

TEST_CASE("simulated hand: a force that is not a number is held as zero", "[device-io]") {
  SimulatedHand hand{DeviceConfig{}};
  read_at(hand, 0);
  hand.write({{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}});
  CHECK(hand.held().f == Vec3{});
  hand.write({{0, std::numeric_limits<double>::infinity(), 0}, {}});
  CHECK(hand.held().f == Vec3{});
  CHECK(is_finite(read_at(hand, kMs).X_BH));
}

TEST_CASE("simulated hand: a late tick holds the force for as long as it was late", "[device-io]") {
  DeviceConfig config;
  SimulatedHand punctual(config), late(config);
  read_at(punctual, 0);
  read_at(late, 0);
  punctual.write({{5, 0, 0}, {}});
  late.write({{5, 0, 0}, {}});
  for (int k = 1; k <= 20; ++k) read_at(punctual, k * kMs);
  read_at(late, 20 * kMs);
  // the same held force over the same time: only the grouping of the steps differs
  CHECK_THAT(late.plant().p_B, IsNear(punctual.plant().p_B, kAlgebra));
}

TEST_CASE("simulated hand: a read one second late is bounded and flagged", "[device-io]") {
  SimulatedHand hand{DeviceConfig{}};
  read_at(hand, 0);
  hand.write({{8, 0, 0}, {}});
  const DeviceState state = read_at(hand, 1000 * kMs);
  CHECK(state.t_ns == 1000 * kMs);
  CHECK(hand.plant().t_ns == kMaxCatchUpNs);
  CHECK((state.flags & kDeviceLostTime) != 0);
  // skipped time did not move it, and the next period is a normal one
  CHECK(norm(hand.plant().v_B) < 2);
  CHECK((read_at(hand, 1001 * kMs).flags & kDeviceLostTime) == 0);
  CHECK(hand.plant().t_ns == kMaxCatchUpNs + kMs);
}

TEST_CASE("simulated hand: a clock that stands still gives the last state, held", "[device-io]") {
  SimulatedHand hand{DeviceConfig{}};
  const DeviceState first = read_at(hand, kMs);
  DeviceState again{};
  CHECK_FALSE(hand.read(tick_at(kMs), again));
  CHECK(again.X_BH == first.X_BH);
  CHECK((again.flags & kDeviceHeld) != 0);
  CHECK((again.flags & kDeviceFresh) == 0);
}

TEST_CASE("simulated hand: stop holds zero", "[device-io]") {
  const auto device = open_device(DeviceConfig{});
  read_at(*device, 0);
  device->write({{1, 2, 3}, {}});
  device->stop();
  device->stop();
  CHECK(dynamic_cast<SimulatedHand&>(*device).held().f == Vec3{});
  CHECK(device->caps().simulated);
  CHECK_FALSE(device->caps().open_loop);
}
