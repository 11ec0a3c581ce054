// SPDX-License-Identifier: GPL-3.0-or-later
// The driver and an emulated board that lies: frozen, late or noisy. And honest boards that hardly
// move.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "device-io/hand/impedance.h"
#include "tests/support/emulated_woodenhaptics.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using haptic::test::EmulatedWoodenHaptics;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStart = 1'000 * kMs;  // of the ticks
constexpr double kStiffness = 500;       // of the wall [N/m]
constexpr int kFoundWithin = 100;        // as documented [ticks]
constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;

/// A hand of this kind that constantly aims `press` below the origin, with a tremor of 0.1 mm.
EmulatedDeviceOptions pressing(const char* hand, double press) {
  EmulatedDeviceOptions options;
  options.hand.mass = 0.15;
  options.hand.damping = 0.3;
  options.hand.coulomb_friction = 0.2;
  put_into_hand(*find_hand(hand), options.hand);
  options.hand.intent.centre_B = {0, 0, -press};
  options.hand.intent.direction_B = {0, 0, 1};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = 0;
  options.hand.intent.tremor_amplitude = 1e-4;
  return options;
}

/// A wall at z = 0 under the hand, and the driver's flags, tick by tick.
struct Wall {
  EmulatedWoodenHaptics device;
  DeviceState state{};
  int tick = 0;
  uint32_t seen = 0;  // flags so far

  explicit Wall(const EmulatedDeviceOptions& options) : device(options) {}

  void step() {
    const int64_t t_ns = kStart + tick++ * kMs;
    device.read({t_ns, t_ns}, state);
    seen |= state.flags;
    const bool closed = (state.flags & (kDeviceLost | kDoubt)) != 0;
    device.write({{0, 0, closed ? 0 : -kStiffness * std::min(0.0, state.X_BH.p.z)}, {}});
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
  /// Ticks until a flag is set; -1: not within so many.
  int ticks_until(uint32_t flag, int most) {
    for (int i = 0; i < most; ++i) {
      step();
      if ((state.flags & flag) != 0) return i + 1;
    }
    return -1;
  }
  int32_t largest_current() const {
    const auto& i = device.driver().currents();
    return std::max({std::abs(i[0]), std::abs(i[1]), std::abs(i[2])});
  }
};

/// The flag is set within the documented time, and then the motors are off.
void check_found(Wall& w, uint32_t flag) {
  const int found = w.ticks_until(flag, 1000);
  CAPTURE(found);
  CHECK(found > 0);
  CHECK(found <= kFoundWithin);
  w.run(10);
  CHECK(w.largest_current() == 0);
}

}  // namespace

TEST_CASE("lying device: frozen, it is found and gets zero", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100 + GENERATE(0, 13));
  REQUIRE(w.largest_current() > 300);
  REQUIRE((w.seen & kDoubt) == 0);
  w.device.board().lie(EmulatorFault::kFrozen);
  check_found(w, kDeviceStale);
  // and as long as it lasts
  w.run(2000);
  CHECK((w.state.flags & kDeviceStale) != 0);
  CHECK(w.largest_current() == 0);
}

TEST_CASE("lying device: answers that are a second old are found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100 + GENERATE(0, 13));
  REQUIRE(w.largest_current() > 300);
  const auto how = GENERATE(EmulatorFault::kOldFirst, EmulatorFault::kDelayed);
  w.device.board().lie(how);
  check_found(w, kDeviceStale);
}

TEST_CASE("lying device: noise on one encoder is found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(500);
  w.device.board().lie(EmulatorFault::kNoise);
  check_found(w, kDeviceNoisy);
}

TEST_CASE("lying device: once it is honest again the driver says so", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(500);
  const auto how = GENERATE(EmulatorFault::kFrozen, EmulatorFault::kOldFirst,
                            EmulatorFault::kDelayed, EmulatorFault::kNoise);
  w.device.board().lie(how);
  w.run(200);
  REQUIRE((w.state.flags & kDoubt) != 0);
  w.device.board().lie(EmulatorFault::kHealthy);
  w.run(1000);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.largest_current() > 300);
}

TEST_CASE("lying device: a clamped handle at full force is no fault", "[device-io]") {
  // no motion reaches a count: the encoders are constant for ten minutes
  EmulatedDeviceOptions clamped = pressing("stiff-arm", 0.0095);
  clamped.hand.hand_stiffness = 1e6;
  clamped.hand.intent.tremor_amplitude = 0;
  Wall w(clamped);
  w.run(1000);
  REQUIRE(w.largest_current() > 800);
  const MotorCounts held = w.device.board().record().counts;
  // ten minutes are 600,000 ticks: HAPTIC_TORTURE_SCALE=30
  const auto ticks = static_cast<int>(test::sweep(20'000));
  bool moved = false;
  for (int i = 0; i < ticks; ++i) {
    w.step();
    moved |= w.device.board().record().counts != held;
  }
  CHECK_FALSE(moved);
  CHECK((w.seen & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.largest_current() > 800);
}

TEST_CASE("lying device: a servo that is held up, and lines of hapticd meanwhile, are no lie",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(100);
  for (int round = 0; round < 300; ++round) {
    w.run(1 + round % 7);
    // up to four, some of which overtake each other in the queue
    for (int i = 0; i < round % 5; ++i) {
      w.device.board().receive({kZeroCommand.data(), kZeroCommand.size()});
      if (round % 2 == 0) w.device.pass(kStart + (w.tick + i) * kMs);
    }
    w.tick += 6 + round % 90;
  }
  CHECK((w.seen & kDoubt) == 0);
  w.run(100);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.largest_current() > 300);
}

TEST_CASE("lying device: an honest one behind a busy machine is believed, however late it is") {
  // bytes delayed for lack of a processor, up to the allowed silence; constant or random
  const int most_ms = GENERATE(3, 6, 9, 12, 15), by_chance = GENERATE(0, 1);
  Wall wall(pressing("stiff-arm", 5e-3));
  wall.run(200);
  std::mt19937 random(5);
  int lost = 0;
  constexpr int kTicks = 3000;
  for (int i = 0; i < kTicks; ++i) {
    if (i % 7 == 0) {
      const double share = by_chance != 0 ? std::uniform_real_distribution<>(0, 1)(random) : 1;
      wall.device.delay_ns = static_cast<int64_t>(share * most_ms * kMs);
    }
    wall.step();
    lost += (wall.state.flags & kDeviceLost) != 0;
  }
  CAPTURE(most_ms, by_chance, lost);
  CHECK((wall.seen & kDoubt) == 0);
  CHECK(lost == 0);
  // and as soon as the machine is idle again, everything is as before
  wall.device.delay_ns = 0;
  wall.run(100);
  CHECK((wall.state.flags & (kDeviceLost | kDeviceHomed | kDoubt)) == kDeviceHomed);
}
