// SPDX-License-Identifier: GPL-3.0-or-later
// Each driver and an emulated device that lies, falls silent or is gone: it is found, and gets
// zero.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "proto/math/units.h"
#include "tests/support/driver/rows.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int kFoundWithin = 100;  // as documented [ticks]

/// A driver and a lie of its device.
struct Liar {
  DriverRow row;
  Lie lie;
};

std::vector<Liar> liars(std::vector<Lie> DriverRow::*lies) {
  std::vector<Liar> all;
  for (const DriverRow& row : driver_rows()) {
    for (const Lie lie : row.*lies) all.push_back({row, lie});
  }
  return all;
}

/// The flag is set within the documented time, and the motors are off while the lie lasts; then the
/// device is believed again, and pushes.
void check_found(Wall& w, Lie lie, uint32_t flags) {
  w.bench->lie(lie);
  const int found = w.ticks_until(flags, 10 * kFoundWithin);
  CAPTURE(w.row.name, static_cast<int>(lie), found);
  CHECK(found > 0);
  CHECK(found <= kFoundWithin);
  w.run(10);
  // of one that goes on with old answers in their order a driver may have to be persuaded anew
  const int lasts = lie == Lie::kFrozen ? 2000 : 200;
  for (int i = 0; i < lasts; ++i) {
    w.step();
    if (w.bench->effort() != 0 || !w.has(kDoubt | kDeviceLost)) FAIL("tick " << i);
  }
  if (lie == Lie::kFrozen) CHECK(w.has(kDeviceStale));
  w.bench->lie(Lie::kHealthy);
  w.run(1200);
  CHECK_FALSE(w.has(kDoubt | kDeviceLost));
  CHECK(w.is_working());
}

}  // namespace

TEST_CASE("lying device: frozen, old or mixed up answers are found, and honest ones believed",
          "[device-io]") {
  const Liar liar = GENERATE(from_range(liars(&DriverRow::old_answers)));
  // between two challenges, of those that are challenged on a line
  const int later = GENERATE(0, 13);
  if (later > 0 && liar.row.has_thread) return;
  Wall w(liar.row);
  w.run(later);
  check_found(w, liar.lie, liar.row.stale);
  if (liar.lie == Lie::kOldFirst || liar.lie == Lie::kDelayed) {
    CHECK(w.bench->oddities() >= liar.row.fewest_odd);
  }
}

TEST_CASE("lying device: noise on one encoder is found", "[device-io]") {
  const Liar liar = GENERATE(from_range(liars(&DriverRow::noises)));
  Wall w(liar.row);
  check_found(w, liar.lie, kDeviceNoisy);
}

TEST_CASE("lying device: an encoder that counts wrong drives nothing beyond the limits",
          "[device-io]") {
  // honest to the protocol; the hand's motion is wrong, and the limits hold all the same
  const Liar liar = GENERATE(from_range(liars(&DriverRow::wrong_counts)));
  const size_t encoder = GENERATE_COPY(from_range(liar.row.wrong_encoders));
  const bool from_start = GENERATE(false, true);
  if (from_start && liar.row.has_thread) return;
  CAPTURE(liar.row.name, static_cast<int>(liar.lie), encoder, from_start);
  Wall w(liar.row, pressing(liar.row, "typical", liar.row.wall.depth));
  if (!from_start) w.run(1100);
  w.bench->encoder = encoder;
  w.bench->lie(liar.lie);
  double effort = 0, force = 0;
  for (int i = 0; i < 2500; ++i) {
    w.step();
    effort = std::max(effort, w.bench->effort());
    force = std::max(force, norm(w.bench->felt_B().f));
    REQUIRE(is_finite(w.state.X_BH.p));
  }
  CHECK(effort <= liar.row.limits.effort * 1.0001);
  // bounded at the pose that the driver believes; at the true one by the motors
  CHECK(force <= liar.row.limits.misled * liar.row.limits.force);
}

TEST_CASE("lying device: silent or in halves, it is lost within 22 ms and comes back with zero",
          "[device-io]") {
  const Liar liar = GENERATE(from_range(liars(&DriverRow::silences)));
  CAPTURE(liar.row.name, static_cast<int>(liar.lie));
  Wall w(liar.row);
  w.bench->lie(liar.lie);
  const int found = w.ticks_until(kDeviceLost, 100);
  CHECK(found > 0);
  CHECK(found <= 22);
  // one that hears but cannot be read lets go at once
  int held = 0;
  while (liar.row.hears_in_silence && w.bench->effort() != 0 && held < 100) w.run(1), ++held;
  CAPTURE(found, held);
  CHECK(found + held <= 24);
  w.run(300);
  CHECK(w.has(kDeviceLost));
  // one that hears nothing has held its force; what waits for it ends with zero
  if (liar.row.hears_in_silence) CHECK(w.bench->effort() == 0);
  w.bench->lie(Lie::kHealthy);
  w.bench->pass(w.t_ns + 2 * kMs);
  CHECK(w.bench->effort() == 0);
  w.run(500);
  CHECK_FALSE(w.has(kDoubt | kDeviceLost));
  CHECK(w.is_working());
}

TEST_CASE("lying device: lost bytes and half packets cost samples, not sense", "[device-io]") {
  const Liar liar = GENERATE(from_range(liars(&DriverRow::losses)));
  CAPTURE(liar.row.name, static_cast<int>(liar.lie));
  SimulatedHandConfig hand = pressing(liar.row, "typical", liar.row.wall.depth);
  hand.intent.tremor_amplitude = 0;
  Wall w(liar.row, hand);
  w.run(1100);
  const Vec3 settled_B = w.state.X_BH.p;
  w.bench->lie(liar.lie);
  double farthest = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    farthest = std::max(farthest, norm(w.state.X_BH.p - settled_B));
  }
  CHECK(farthest < 0.002);
  CHECK((w.state.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed);
  CHECK((w.seen & kDoubt) == 0);
  if (liar.lie == Lie::kLoses) CHECK(w.fresh < 3000);
}

TEST_CASE("driver: without power or plug it is lost", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  Wall w(row);
  const Vec3 last_B = w.state.X_BH.p;
  w.bench->cut();
  const int found = w.ticks_until(kDeviceLost, 100);
  CHECK(found > 0);
  CHECK(found <= row.gone_within);
  w.run(100);
  CHECK(w.has(kDeviceLost));
  CHECK(norm(w.state.X_BH.p - last_B) < 0.01);
}

TEST_CASE("driver: a servo that stands still lets go of the device", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  Wall w(row);
  if (row.lets_go_ms == 0) return;
  w.bench->pass(w.t_ns + row.lets_go_ms * kMs);
  CHECK(w.bench->effort() == 0);
  CHECK(w.bench->felt_B() == Wrench{});
}
