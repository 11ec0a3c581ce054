// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/simulated_hand.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::tol;

namespace {

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

/// A handle that turns, held by a wrist that stands still.
DeviceConfig turning_device() {
  DeviceConfig config;
  config.max_torque = 0.3;
  config.hand.inertia = 1e-4;
  config.hand.intent.stroke_time = 1e6;  // stands still
  config.hand.intent.tremor_amplitude = 0;
  return config;
}

/// Place or rotation vector.
Vec3 part_of(const Pose& X_BH, bool turns) {
  return turns ? to_rotation_vector(X_BH.q) : X_BH.p;
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

TEST_CASE("simulated hand: the pose is the encoder's step below the true one, turned or moved",
          "[device-io]") {
  const bool turns = GENERATE(false, true);
  const double step = turns ? 1e-3 : 1e-4;
  DeviceConfig config = turning_device();
  config.hand.encoder_step = 1e-4;
  config.hand.angle_step = 1e-3;
  SimulatedHand hand(config);
  const Vec3 began = part_of({hand.plant().p_B, hand.plant().q_B}, turns);
  Vec3 there;
  for (int k = 0; k < 500; ++k) {
    const Vec3 read = part_of(read_at(hand, k * kMs).X_BH, turns);
    there = part_of({hand.plant().p_B, hand.plant().q_B}, turns);
    for (int i = 0; i < 3; ++i) {
      REQUIRE(there[i] - read[i] >= -tol(kAlgebra));
      REQUIRE(there[i] - read[i] < step + tol(kAlgebra));
      REQUIRE(std::fabs(std::remainder(read[i], step)) <= tol(kAlgebra));
    }
    hand.write({{2, -1, 0.5}, {0.2, -0.1, 0.05}});
  }
  CHECK(norm(there - began) > 20 * step);
}

TEST_CASE("simulated hand: the velocity follows a ramp after the time constant of its filter",
          "[device-io]") {
  const bool turns = GENERATE(false, true);
  DeviceConfig config = turning_device();
  SimulatedHandConfig& h = config.hand;
  h.encoder_step = h.coulomb_friction = h.damping = 0;
  h.hand_stiffness = h.hand_damping = h.hand_mass = 0;
  h.angle_step = h.rotational_friction = h.rotational_damping = 0;
  h.hand_rotational_stiffness = h.hand_rotational_damping = h.hand_inertia = 0;
  SimulatedHand hand(config);
  // a constant push: v = a t, seen late by the pole and half a period of differencing
  const double a = turns ? 20 : 0.5, T = 1e-3, pole = 1 / (2 * std::numbers::pi * 100);
  const Vec3 axis = normalized(Vec3{2, -1, 2});
  DeviceState state{};
  for (int k = 0; k <= 100; ++k) {
    state = read_at(hand, k * kMs);
    hand.write({turns ? Vec3{} : a * h.mass * axis, turns ? a * h.inertia * axis : Vec3{}});
  }
  // y += T/(T+τ)(u − y) lags a ramp by τ
  const Vec3 seen = turns ? state.V_BH.w : state.V_BH.v;
  CHECK_THAT(seen, IsNear(a * (0.1 - T / 2 - pole) * axis, turns ? 1e-4 : 1e-6));
  CHECK_THAT(turns ? hand.plant().w_B : hand.plant().v_B, IsNear(a * 0.1 * axis, 1e-9));
}

TEST_CASE("simulated hand: force and torque are each shortened, and keep their direction",
          "[device-io]") {
  DeviceConfig config = turning_device();
  config.max_force = 8;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const Vec3 force{12, -16, 5}, torque{0.3, -0.4, 0};
  struct Row {
    Wrench wanted, held;
    bool is_cut = true;
  };
  const Row row = GENERATE_COPY(
      Row{{force, {}}, {8 / norm(force) * force, {}}}, Row{{{3, 0, 4}, {}}, {{3, 0, 4}, {}}, false},
      Row{{{1, 2, 3}, torque}, {{1, 2, 3}, 0.6 * torque}},
      Row{{{1, 2, 3}, 0.5 * torque}, {{1, 2, 3}, 0.5 * torque}, false}, Row{{{nan, 0, 0}, {}}, {}},
      Row{{{0, infinity, 0}, {}}, {}}, Row{{{}, {0, nan, 0}}, {}});
  SimulatedHand hand(config);
  read_at(hand, 0);
  hand.write(row.wanted);
  CHECK_THAT(hand.held().f, IsNear(row.held.f, 8 * kAlgebra));
  CHECK_THAT(hand.held().t, IsNear(row.held.t, kAlgebra));
  const DeviceState state = read_at(hand, kMs);
  CHECK(((state.flags & kDeviceSaturated) != 0) == row.is_cut);
  CHECK(is_finite(state.X_BH));
  hand.write({});
  CHECK((read_at(hand, 2 * kMs).flags & kDeviceSaturated) == 0);
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

TEST_CASE("simulated hand: without an inertia nothing of turning is seen, to the bit",
          "[device-io]") {
  DeviceConfig plain, other;
  other.max_torque = 0.3;
  other.hand.rotational_damping = 1;
  other.hand.hand_rotational_stiffness = 100;
  other.hand.intent.turn_angle = 1;
  SimulatedHand first(plain), second(other);
  CHECK(second.caps().max_torque == 0);
  for (int k = 0; k < 1000; ++k) {
    const DeviceState a = read_at(first, k * kMs), b = read_at(second, k * kMs);
    REQUIRE(std::memcmp(&a, &b, sizeof a) == 0);
    first.write({{0.1, 0, -0.2}, {}});
    second.write({{0.1, 0, -0.2}, {1, 2, 3}});
  }
  CHECK(second.held().t == Vec3{});
}

TEST_CASE("simulated hand: turning leaves the positions as they are, to the bit", "[device-io]") {
  DeviceConfig plain, turning;
  turning.hand.inertia = 1e-4;
  turning.hand.intent.turn_angle = 0.5;
  turning.max_torque = 0.3;
  SimulatedHand first(plain), second(turning);
  for (int k = 0; k < 2000; ++k) {
    const DeviceState a = read_at(first, k * kMs), b = read_at(second, k * kMs);
    REQUIRE(a.X_BH.p == b.X_BH.p);
    REQUIRE(a.V_BH.v == b.V_BH.v);
    first.write({{0.1, 0, -0.2}, {}});
    second.write({{0.1, 0, -0.2}, {0.01, 0, 0.02}});
  }
}

TEST_CASE("simulated hand: it turns under the held torque by torque over stiffness",
          "[device-io]") {
  DeviceConfig config = turning_device();
  config.hand.rotational_friction = 0;
  config.hand.angle_step = 0;
  SimulatedHand hand(config);
  const Vec3 torque{0.05, -0.1, 0.08};
  DeviceState state{};
  for (int k = 0; k < 3000; ++k) {
    state = read_at(hand, k * kMs);
    hand.write({{}, torque});
  }
  CHECK(hand.caps().max_torque == 0.3);
  CHECK_THAT(to_rotation_vector(state.X_BH.q),
             IsNear(torque / config.hand.hand_rotational_stiffness, 1e-9));
  CHECK((state.flags & kDeviceSaturated) == 0);
}
