// SPDX-License-Identifier: GPL-3.0-or-later
// Each driver and its emulated device on virtual time, known to each other by their bytes: what all
// drivers do with an honest device. Its particular bytes and kinematics have tests of their own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "proto/math/units.h"
#include "tests/support/driver/rows.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<DriverRow> rows_and_variants() {
  std::vector<DriverRow> all = driver_rows();
  all.insert(all.end(), driver_variants().begin(), driver_variants().end());
  return all;
}

std::vector<DriverRow> rows_where(bool (*holds)(const DriverRow&)) {
  std::vector<DriverRow> all;
  std::ranges::copy_if(driver_rows(), std::back_inserter(all), holds);
  return all;
}

/// Level with the wall.
Vec3 aside(const DriverRow& row) {
  return cross(row.wall.out_B, {0, 0, 1}) == Vec3{} ? Vec3{1, 0, 0}
                                                    : cross(row.wall.out_B, {0, 0, 1});
}

}  // namespace

TEST_CASE("driver: the pose is that of the hand, to a count, and each tick has its sample",
          "[device-io]") {
  const DriverRow row = GENERATE(from_range(rows_and_variants()));
  INFO(row.name);
  SimulatedHandConfig hand = pressing(row, "typical", 0);
  hand.intent.centre_B += 0.02 * aside(row) + 0.005 * row.wall.out_B;
  hand.coulomb_friction = hand.intent.tremor_amplitude = 0;
  Wall w(row, hand);
  w.run(1500);
  CHECK_THAT(w.state.X_BH.p, IsNear(w.bench->plant().p_B, row.steps.place));
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.bench->oddities() == 0);
  CHECK(w.fresh > row.fewest_samples);
  if (row.is_flat) CHECK(w.state.X_BH.p.z == 0);
}

TEST_CASE("driver: the force at the handle is the one commanded", "[device-io]") {
  // what the device cannot exert is dropped before the limits: torque of one without such motors,
  // force out of the plane of one that moves in it
  const DriverRow row = GENERATE(from_range(rows_and_variants()));
  INFO(row.name);
  Wall w(row, pressing(row, "stiff-arm", 0.4 * row.wall.depth));
  const Vec3 aside_B = 0.3 * aside(row);
  w.also_B.f = aside_B + Vec3{0, 0, row.is_flat ? 100.0 : 0.0};
  if (row.limits.torque == 0) w.also_B.t = {10, -20, 30};
  w.run(2000);
  REQUIRE(w.wall_force() > 0.7);
  CHECK_THAT(w.bench->felt_B().f,
             IsNear(w.wall_force() * row.wall.out_B + aside_B, row.steps.force));
  CHECK((w.seen & kDeviceSaturated) == 0);
}

TEST_CASE("driver: pose and velocity follow a hand that turns the handle", "[device-io]") {
  const DriverRow row =
      GENERATE(from_range(rows_where([](const DriverRow& r) { return r.steps.turn > 0; })));
  INFO(row.name);
  Wall w(row, holding(row, 0.7));
  w.stiffness = 0;
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    const HandPlant before = w.bench->plant();
    w.step();
    if (i < 100) continue;
    REQUIRE(w.has(kDeviceFresh));
    // a tick old, and some counts
    const double speed = norm(before.w_B);
    const Quat off = w.state.X_BH.q * conjugate(before.q_B);
    REQUIRE(norm(to_rotation_vector(off)) < row.steps.turn + 2.5e-3 * speed);
    REQUIRE(norm(w.state.X_BH.p - before.p_B) < 3e-4);
    // a count each in a tick is 0.4 rad/s, through the pole of 1.6 ms; and it lags behind
    if (row.limits.torque > 0) REQUIRE(norm(w.state.V_BH.w - before.w_B) < 0.5 + 0.2 * speed);
    fastest = std::max(fastest, speed);
  }
  CHECK(fastest > 1.2);
  CHECK((w.seen & kDoubt) == 0);
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
}

TEST_CASE("driver: a hand gets force and torque, within some units of the motors", "[device-io]") {
  const DriverRow row =
      GENERATE(from_range(rows_where([](const DriverRow& r) { return r.limits.torque > 0; })));
  const Wrench F_B = GENERATE(Wrench{{1, -2, 0.5}, {0.05, -0.08, 0.1}}, Wrench{{}, {0.1, 0, 0}},
                              Wrench{{}, {0, 0.1, 0}}, Wrench{{}, {0, 0, -0.1}},
                              Wrench{{0, 0, 2}, {}}, Wrench{{-2, 0, 0}, {0, 0, 0.02}});
  INFO(row.name);
  Wall w(row, holding(row));
  w.stiffness = 0;
  w.also_B = F_B;
  w.run(2000);
  CHECK((w.seen & (kDeviceSaturated | kDeviceLost | kDoubt)) == 0);
  CHECK(w.has(kDeviceFresh));
  // by the board's own joint angles, which the driver knows to a count
  const auto off = [&](const Vec3& B, double unit) {
    return tol(unit + row.steps.share * norm(B));
  };
  CHECK_THAT(w.bench->felt_B().f, IsNear(F_B.f, off(F_B.f, row.steps.unit_force)));
  CHECK_THAT(w.bench->felt_B().t, IsNear(F_B.t, off(F_B.t, row.steps.unit_torque)));
  // the hand gives way by its springs, 300 N/m and 2 N·m/rad, but for the friction of the device
  const HandPlant& plant = w.bench->plant();
  CHECK_THAT(300 * (plant.p_B - plant.intent_B),
             IsNear(F_B.f, row.body.friction * std::sqrt(3.0) + 1e-2));
  CHECK_THAT(2 * to_rotation_vector(plant.q_B * conjugate(plant.intent_q_B)),
             IsNear(F_B.t, 5e-4 + off(F_B.t, row.steps.unit_torque)));
}

TEST_CASE("driver: torque beyond the device is shortened for itself, or is none", "[device-io]") {
  const DriverRow row =
      GENERATE(from_range(rows_where([](const DriverRow& r) { return r.limits.torque > 0; })));
  INFO(row.name);
  Wall w(row, holding(row));
  w.stiffness = 0;
  w.also_B = {{1, 0, 0}, {0, 10 * row.limits.torque, 0}};
  w.run(50);
  CHECK(w.has(kDeviceSaturated));
  CHECK_THAT(w.bench->felt_B().t, IsNear({0, row.limits.torque, 0}, 25 * row.steps.unit_torque));
  CHECK_THAT(w.bench->felt_B().f, IsNear({1, 0, 0}, 10 * row.steps.unit_force));
  w.also_B.t.z =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  w.run(3);
  CHECK(w.has(kDeviceSaturated));
  CHECK(w.bench->effort() == 0);
}

TEST_CASE("driver: five hands on its wall through its bytes: no limit cycle", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  const char* const name = GENERATE("none", "light-grip", "typical", "firm", "stiff-arm");
  SimulatedHandConfig hand = pressing(row, name, row.wall.depth / 2);
  hand.intent.tremor_amplitude = 0;
  Wall w(row, hand);
  w.run(2000);
  const double swing = w.swing(1000);
  CAPTURE(row.name, name, swing);
  CHECK(swing < row.wall.swing);
}

TEST_CASE("driver: a wall far too stiff is a limit cycle, so that it would be seen",
          "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  SimulatedHandConfig hand = pressing(row, "light-grip", row.wall.depth / 2);
  hand.coulomb_friction = hand.intent.tremor_amplitude = 0;
  Wall w(row, hand);
  w.stiffness = row.wall.too_stiff;
  w.run(2000);
  CHECK(w.swing(1000) > 1);
}

TEST_CASE("driver: its limits are the smaller ones of the device and of the config",
          "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  const SimulatedHandConfig hand = pressing(row, "typical", 0);
  const Wall own(row, hand);
  CHECK(own.bench->caps().max_force == row.limits.force);
  CHECK(own.bench->caps().max_torque == row.limits.torque);
  CHECK_FALSE(own.bench->caps().simulated);
  CHECK(own.bench->description().find(row.describes) != std::string::npos);
  DeviceConfig config;
  config.max_force = 2;
  config.max_torque = 0;
  Wall w(row, hand, config);
  CHECK(w.bench->caps().max_force == 2);
  CHECK(w.bench->caps().max_torque == 0);
  w.also_B = {3 * row.wall.out_B, {0, 0.1, 0}};
  w.run(100);
  CHECK(w.has(kDeviceSaturated));
  CHECK_THAT(w.bench->felt_B().f, IsNear(2 * row.wall.out_B, row.steps.force));
  CHECK(norm(w.bench->felt_B().t) <= tol(2e-4));
}

TEST_CASE("driver: a force beyond the device is shortened, and keeps its direction",
          "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  Wall w(row, pressing(row, "stiff-arm", 0));
  w.run(50);
  const bool is_oblique = GENERATE(false, true);
  const Vec3 wanted_B = (is_oblique ? 30 : 0) * aside(row) + 40 * row.wall.out_B;
  w.read();
  w.bench->write({wanted_B, {}});
  w.bench->pass(w.t_ns + 2 * kMs);
  const Vec3 felt_B = w.bench->felt_B().f;
  const bool at_motor = std::fabs(w.bench->effort() - row.limits.effort) < 1e-3 * row.limits.effort;
  CAPTURE(felt_B, w.bench->effort());
  CHECK_THAT(normalized(felt_B), IsNear(normalized(wanted_B), 0.02));
  CHECK(norm(felt_B) < 1.01 * row.limits.force);
  const bool at_limit = norm(felt_B) > 0.99 * row.limits.force;
  CHECK((at_motor || at_limit));
  if (!is_oblique) CHECK(at_limit != row.limits.is_motors);
  w.read();
  CHECK(w.has(kDeviceSaturated));
}

TEST_CASE("driver: of weak motors all get the same share of their currents", "[device-io]") {
  const DriverRow row =
      GENERATE(from_range(rows_where([](const DriverRow& r) { return r.has_currents; })));
  INFO(row.name);
  DeviceConfig config;
  config.max_torque = 0.3;
  config.serial.max_current = 0.5;
  Wall w(row, holding(row), config);
  w.stiffness = 0;
  const Wrench wanted_B{{0, 1.5, 2}, {0, row.limits.torque / 2, 0}};
  w.also_B = wanted_B;
  w.run(50);
  CHECK(w.has(kDeviceSaturated));
  CHECK(w.bench->effort() == 500);
  const Wrench felt_B = w.bench->felt_B();
  CHECK_THAT(normalized(felt_B.f), IsNear(normalized(wanted_B.f), 0.02));
  if (row.limits.torque > 0) {
    CHECK(felt_B.f.z / wanted_B.f.z == Approx(felt_B.t.y / wanted_B.t.y).epsilon(0.02));
  }
}

TEST_CASE("driver: a wrench that is not finite is no force, and that is said", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  INFO(row.name);
  Wall w(row);
  w.read();
  w.bench->write({{0, bad, 0}, {}});
  w.bench->pass(w.t_ns + 3 * kMs);
  CHECK(w.bench->effort() == 0);
  w.t_ns += 3 * kMs;
  w.read();
  CHECK(w.has(kDeviceSaturated));
  CHECK(is_finite(w.state.X_BH.p));
}

TEST_CASE("driver: the zero of hapticd lets go of its device, and its answers are no lie",
          "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  Wall w(row);
  const DeviceRelease release = w.bench->release();
  const std::string_view zero{release.bytes.data(), release.size};
  CHECK(release.by == static_cast<uint32_t>(row.release_by));
  CHECK(zero == row.release);
  if (row.release_by == ReleaseBy::kUsbBulk) CHECK(release.endpoint == 2);
  for (int i = 0; i < 4; ++i) {
    // what the servo has said last arrives before it
    if (!row.has_thread) w.bench->pass(w.t_ns += kMs);
    w.bench->tell(zero);
    // a thread of transfers goes on with what the servo wants
    if (!row.has_thread) w.bench->pass(w.t_ns += 5 * kMs);
    CHECK(w.bench->effort() == 0);
    if (row.has_thread) w.run(5);
  }
  w.run(200);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.is_working());
}

TEST_CASE("lying device: an honest one behind a busy machine is believed, however late it is",
          "[device-io]") {
  // bytes delayed for lack of a processor, up to the allowed silence; constant or random
  const DriverRow row =
      GENERATE(from_range(rows_where([](const DriverRow& r) { return r.most_delay_ms > 0; })));
  const double most = GENERATE(0.2, 0.4, 0.6, 0.8, 1.0);
  const bool by_chance = GENERATE(false, true);
  Wall w(row, pressing(row, "stiff-arm", row.wall.depth / 4));
  const int64_t own_ns = w.bench->delay_ns;
  w.run(200);
  std::mt19937 random(5);
  int lost = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 7 == 0) {
      const double share = by_chance ? std::uniform_real_distribution<>(0.1, 1)(random) : 1;
      w.bench->delay_ns =
          static_cast<int64_t>(share * most * static_cast<double>(row.most_delay_ms * kMs));
    }
    w.step();
    lost += w.has(kDeviceLost);
  }
  CAPTURE(row.name, most, by_chance, lost);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(lost == 0);
  // and as soon as the machine is idle again, everything is as before
  w.bench->delay_ns = own_ns;
  w.run(100);
  CHECK((w.state.flags & (kDeviceLost | kDeviceHomed | kDoubt)) == kDeviceHomed);
}
