// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a WoodenHaptics over HID and an emulated one, on virtual time.
#include "device-io/hidarm/hid_arm.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "device-io/hand/impedance.h"
#include "tests/support/near.h"
#include "tests/support/usb/hid_arm_bench.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr double kStiffness = 500;  // as in configs/woodenhaptics-hid.toml [N/m]
constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;
constexpr int kFoundWithin = 100;  // [ticks]

/// A hand of this kind that aims `press` below the middle, with a tremor of 0.1 mm. Mass, damping
/// and friction of the arm are guesses, as in configs/woodenhaptics.toml.
EmulatedHidArmOptions pressing(const char* hand, double press) {
  EmulatedHidArmOptions options;
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

/// A wall at z = 0 under the hand.
struct Wall {
  HidArmBench bench;
  double stiffness = kStiffness;
  DeviceState state{};
  int64_t t_ns;
  uint32_t seen = 0;

  explicit Wall(const EmulatedHidArmOptions& options) : bench(options), t_ns(bench.t_ns()) {}

  void step() {
    t_ns += kMs;
    bench.read({t_ns, t_ns}, state);
    seen |= state.flags;
    const bool closed = (state.flags & (kDeviceLost | kDoubt)) != 0;
    bench.write({{0, 0, closed ? 0 : -stiffness * std::min(0.0, state.X_BH.p.z)}, {}});
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
  int ticks_until(uint32_t flag, int most) {
    for (int i = 0; i < most; ++i) {
      step();
      if ((state.flags & flag) != 0) return i + 1;
    }
    return -1;
  }
  int largest() const {
    const auto& i = bench.emulated().milliamperes();
    return std::max({std::abs(i[0]), std::abs(i[1]), std::abs(i[2])});
  }
  /// Of the force on the hand, over so many ticks [N].
  double swing(int ticks) {
    double least = 1e9, most = -1e9;
    for (int i = 0; i < ticks; ++i) {
      step();
      least = std::min(least, bench.emulated().force_B().z);
      most = std::max(most, bench.emulated().force_B().z);
    }
    return most - least;
  }
};

void check_found(Wall& w, uint32_t flag) {
  const int found = w.ticks_until(flag, 1000);
  CAPTURE(found);
  CHECK(found > 0);
  CHECK(found <= kFoundWithin);
  w.run(10);
  CHECK(w.largest() == 0);
}

}  // namespace

TEST_CASE("hid arm: the pose is that of the hand, to a count", "[device-io]") {
  EmulatedHidArmOptions options = pressing("typical", 0);
  options.hand.intent.centre_B = {0.03, -0.04, 0.02};
  options.hand.coulomb_friction = 0;
  options.hand.intent.tremor_amplitude = 0;
  if (GENERATE(false, true)) {
    options.arm.links = {0.111, 0.180, 0.211};
    options.arm.signs = {1, -1, 1};
    options.arm.motor_signs = {-1, 1, -1};
  }
  Wall w(options);
  w.run(1500);
  // a count is up to 64 µm for each joint
  CHECK_THAT(w.state.X_BH.p, IsNear(w.bench.emulated().plant().p_B, 150e-6));
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
  CHECK(w.bench.exchange().missed() == 0);
}

TEST_CASE("hid arm: the force at the handle is the one commanded", "[device-io]") {
  Wall w(pressing("stiff-arm", 0.005));
  w.run(2000);
  const double commanded = -kStiffness * w.state.X_BH.p.z;
  REQUIRE(commanded > 1);
  CHECK_THAT(w.bench.emulated().force_B(), IsNear({0, 0, commanded}, 0.15));
}

TEST_CASE("hid arm: five hands on a wall of 500 N/m through its bytes: no limit cycle",
          "[device-io]") {
  const char* const hand = GENERATE("none", "light-grip", "typical", "firm", "stiff-arm");
  EmulatedHidArmOptions options = pressing(hand, 0.01);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(2000);
  const double swing = w.swing(1000);
  CAPTURE(hand, swing);
  // a count at the handle is 64 µm, 32 mN at this stiffness
  CHECK(swing < 0.08);
}

TEST_CASE("hid arm: a wall far too stiff is a limit cycle, so that it would be seen",
          "[device-io]") {
  EmulatedHidArmOptions options = pressing("light-grip", 0.01);
  options.hand.intent.tremor_amplitude = 0;
  options.hand.coulomb_friction = 0;
  Wall w(options);
  w.stiffness = 6000;
  w.run(2000);
  CHECK(w.swing(1000) > 1);
}

TEST_CASE("hid arm: lying device: frozen, it is found and gets zero", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  REQUIRE(w.largest() > 300);
  REQUIRE((w.seen & kDoubt) == 0);
  w.bench.emulated().lie(HidArmFault::kFrozen);
  check_found(w, kDeviceStale | kDeviceLost);
  w.run(500);
  CHECK((w.state.flags & kDeviceStale) != 0);
  CHECK(w.largest() == 0);
}

TEST_CASE("hid arm: lying device: old reports, and a counter that goes anywhere, are found",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(GENERATE(HidArmFault::kOldFirst, HidArmFault::kJumps));
  check_found(w, kDeviceStale | kDeviceLost);
}

TEST_CASE("hid arm: lying device: reports from a queue stand still first, and are found",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(HidArmFault::kDelayed);
  check_found(w, kDeviceStale | kDeviceLost);
}

TEST_CASE("hid arm: lying device: noise on one encoder is found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(HidArmFault::kNoise);
  check_found(w, kDeviceNoisy);
}

TEST_CASE("hid arm: lying device: a flipped encoder drives nothing beyond the limits",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(HidArmFault::kFlipped);
  int most = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    most = std::max(most, w.largest());
  }
  CHECK(std::isfinite(norm(w.state.X_BH.p)));
  CHECK(most <= 3000);
}

TEST_CASE("hid arm: lying device: once it is honest again the driver says so", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(500);
  w.bench.emulated().lie(
      GENERATE(HidArmFault::kFrozen, HidArmFault::kOldFirst, HidArmFault::kNoise));
  w.run(200);
  REQUIRE((w.state.flags & kDoubt) != 0);
  w.bench.emulated().lie(HidArmFault::kHealthy);
  w.run(1200);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.largest() > 300);
}

TEST_CASE("hid arm: silent or in half reports, it is lost within 22 ms", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(GENERATE(HidArmFault::kSilent, HidArmFault::kHalves));
  const int found = w.ticks_until(kDeviceLost, 100);
  CHECK(found > 0);
  CHECK(found <= 22);
}

TEST_CASE("hid arm: unplugged, it is lost at once", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(200);
  w.bench.unplug();
  w.step();
  CHECK((w.state.flags & kDeviceLost) != 0);
}

TEST_CASE("hid arm: lost reports cost samples, not sense", "[device-io]") {
  EmulatedHidArmOptions options = pressing("typical", 0.02);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(1100);
  const double settled = w.state.X_BH.p.z;
  w.bench.emulated().lie(HidArmFault::kLoses);
  double farthest = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    farthest = std::max(farthest, std::fabs(w.state.X_BH.p.z - settled));
  }
  CHECK(farthest < 0.002);
  CHECK(w.bench.exchange().missed() > 100);
  CHECK((w.seen & kDoubt) == 0);
}

TEST_CASE("hid arm: a servo that stands still lets go within 12 ms, a host within 0.5 s",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  REQUIRE(w.largest() > 300);
  w.bench.pass(w.t_ns + 12 * kMs);
  CHECK(w.largest() == 0);
  w.bench.unplug();
  UsbBytes packet;
  w.bench.emulated().give(0x81, 64, packet, w.t_ns + 600 * kMs);
  CHECK_FALSE(w.bench.emulated().is_enabled());
}

TEST_CASE("hid arm: zero force is a HID report", "[device-io]") {
  const DeviceRelease release = HidArmBench(pressing("none", 0)).release();
  CHECK(release.by == static_cast<uint32_t>(ReleaseBy::kHidReport));
  CHECK(release.size == 9);
  CHECK(std::all_of(release.bytes.begin(), release.bytes.end(), [](char c) { return c == 0; }));
}

TEST_CASE("hid arm: counts go on past 16 bits", "[device-io]") {
  auto mailbox = std::make_shared<MotorMailbox>();
  DeviceConfig config;
  config.hid_arm.counts_per_turn = 200'000;  // a turn of A is 3.2 million counts
  ThreeMotorDevice device(hid_arm(config.hid_arm), config, mailbox);
  DeviceState state;
  double before = 0;
  for (int i = 0; i <= 20; ++i) {
    // A turns by 10,000 counts each tick: −2π/320, its sine grows up to 20 of them
    MotorSample sample;
    sample.counts[0] = static_cast<int16_t>(static_cast<uint16_t>(10'000 * i));
    sample.number = static_cast<uint8_t>(i);
    sample.asked_ns = sample.heard_ns = (i + 1) * kMs;
    mailbox->put(sample);
    device.read({(i + 1) * kMs, (i + 1) * kMs}, state);
    if (i > 0) CHECK(state.X_BH.p.y < before);
    before = state.X_BH.p.y;
  }
  // radius of the forearm at home: 0.245 m
  CHECK(state.X_BH.p.y == Approx(-0.245 * std::sin(2 * M_PI * 200'000 / 3.2e6)).epsilon(1e-6));
}
