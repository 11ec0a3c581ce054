// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a Haply board and an emulated one, on virtual time.
#include "device-io/haply/haply.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "device-io/hand/impedance.h"
#include "tests/support/haply/haply_bench.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr double kStiffness = 300;  // as in configs/haply.toml [N/m]
constexpr double kWallAt = 0.075;   // y of the wall [m]
constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;
constexpr int kFoundWithin = 100;  // [ticks]

/// A hand of this kind that aims `press` into the wall, with a tremor of 0.1 mm. Mass, damping and
/// friction of the device are guesses, as in configs/haply.toml.
EmulatedHaplyOptions pressing(const char* hand, double press) {
  EmulatedHaplyOptions options;
  options.hand.mass = 0.1;
  options.hand.damping = 0.3;
  options.hand.coulomb_friction = 0.1;
  put_into_hand(*find_hand(hand), options.hand);
  options.hand.intent.centre_B = {0, kWallAt - press, 0};
  options.hand.intent.direction_B = {0, 1, 0};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = 0;
  options.hand.intent.tremor_amplitude = 1e-4;
  return options;
}

/// A wall between the hand and the motors.
struct Wall {
  HaplyBench bench;
  double stiffness = kStiffness;
  Vec3 also_B;  // force beside that of the wall [N]
  DeviceState state{};
  int64_t t_ns;
  uint32_t seen = 0;  // flags so far

  explicit Wall(const EmulatedHaplyOptions& options) : bench(options), t_ns(bench.t_ns()) {}

  void step() {
    t_ns += kMs;
    bench.read({t_ns, t_ns}, state);
    seen |= state.flags & ~(state.t_ns == 0 ? uint32_t{kDeviceLost} : 0);
    const bool closed = (state.flags & (kDeviceLost | kDoubt)) != 0;
    const Vec3 wall_B{0, stiffness * std::max(0.0, kWallAt - state.X_BH.p.y), 0};
    bench.write({closed ? Vec3{} : wall_B + also_B, {}});
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
  double torque() { return bench.emulated().largest_torque(); }
  /// Of the force on the hand, over so many ticks [N].
  double swing(int ticks) {
    double least = 1e9, most = -1e9;
    for (int i = 0; i < ticks; ++i) {
      step();
      least = std::min(least, bench.emulated().force_B().y);
      most = std::max(most, bench.emulated().force_B().y);
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
  CHECK(w.torque() == 0);
}

}  // namespace

TEST_CASE("haply: the pose is that of the hand, to a count", "[device-io]") {
  EmulatedHaplyOptions options = pressing("typical", 0);
  options.hand.intent.centre_B = {0.02, 0.08, 0};
  options.hand.coulomb_friction = 0;
  options.hand.intent.tremor_amplitude = 0;
  SECTION("the board with a Due") {}
  SECTION("an M0, which counts every other edge") {
    options.is_m0 = true;
  }
  SECTION("other signs, ports and lengths") {
    options.arm.sign_1 = -1;
    options.arm.port_1 = 2;
    options.arm.base = 0;
    options.arm.distal = 0.08;
    options.home_B = {0, std::sqrt(0.08 * 0.08 - 0.05 * 0.05), 0};
  }
  Wall w(options);
  w.run(1500);
  // a count is up to 50 µm for each link, twice that on the M0
  CHECK_THAT(w.state.X_BH.p, IsNear(w.bench.emulated().plant().p_B, 150e-6));
  CHECK(w.state.X_BH.p.z == 0);
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
  CHECK(w.bench.exchange().old() == 0);
  // a question a tick, and its answer in the next one
  CHECK(w.bench.exchange().answered() > 1490);
}

TEST_CASE("haply: the force at the handle is the one commanded", "[device-io]") {
  EmulatedHaplyOptions options = pressing("stiff-arm", 0.004);
  SECTION("the board with a Due") {}
  SECTION("other signs, ports and torques") {
    options.arm.sign_1 = -1;
    options.arm.port_1 = 2;
    options.arm.reduction = 2;
  }
  Wall w(options);
  w.also_B = {0.3, 0, 0};
  w.run(2000);
  const double commanded = kStiffness * (kWallAt - w.state.X_BH.p.y);
  REQUIRE(commanded > 0.7);
  CHECK_THAT(w.bench.emulated().force_B(), IsNear({0.3, commanded, 0}, 0.02));
  CHECK((w.seen & kDeviceSaturated) == 0);
}

TEST_CASE("haply: force out of the plane is dropped, before the limits", "[device-io]") {
  Wall w(pressing("stiff-arm", 0.004));
  w.also_B = {0, 0, 100};
  w.run(2000);
  const double commanded = kStiffness * (kWallAt - w.state.X_BH.p.y);
  REQUIRE(commanded > 0.7);
  CHECK_THAT(w.bench.emulated().force_B(), IsNear({0, commanded, 0}, 0.02));
  CHECK((w.seen & kDeviceSaturated) == 0);
  CHECK(w.bench.description().find("2 axes") != std::string::npos);
}

TEST_CASE("haply: a force beyond a motor is shortened and keeps its direction", "[device-io]") {
  Wall w(pressing("stiff-arm", 0));
  w.also_B = {2, 4, 0};
  w.run(500);
  const Vec3 force = w.bench.emulated().force_B();
  CHECK((w.state.flags & kDeviceSaturated) != 0);
  CHECK(w.torque() == Approx(0.123).epsilon(1e-3));
  CHECK(force.y / force.x == Approx(2).epsilon(0.02));
}

TEST_CASE("haply: five hands on a wall of 300 N/m through its bytes: no limit cycle",
          "[device-io]") {
  const char* const hand = GENERATE("none", "light-grip", "typical", "firm", "stiff-arm");
  EmulatedHaplyOptions options = pressing(hand, 0.005);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(2000);
  const double swing = w.swing(1000);
  CAPTURE(hand, swing);
  // a count at the handle is up to 50 µm, 15 mN at this stiffness
  CHECK(swing < 0.04);
}

TEST_CASE("haply: a wall far too stiff is a limit cycle, so that it would be seen", "[device-io]") {
  EmulatedHaplyOptions options = pressing("light-grip", 0.005);
  options.hand.intent.tremor_amplitude = 0;
  options.hand.coulomb_friction = 0;
  Wall w(options);
  w.stiffness = 6000;
  w.run(2000);
  CHECK(w.swing(1000) > 1);
}

TEST_CASE("haply: lying device: frozen, it is found and gets zero", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  REQUIRE(w.torque() > 0.01);
  REQUIRE((w.seen & kDoubt) == 0);
  w.bench.emulated().lie(HaplyFault::kFrozen);
  check_found(w, kDeviceStale);
  w.run(2000);
  CHECK((w.state.flags & (kDeviceStale | kDeviceLost)) != 0);
  CHECK(w.torque() == 0);
}

TEST_CASE("haply: lying device: old answers, first or instead, are found", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100 + GENERATE(0, 13));
  w.bench.emulated().lie(GENERATE(HaplyFault::kOldFirst, HaplyFault::kDelayed));
  check_found(w, kDeviceStale);
  CHECK(w.bench.exchange().old() >= 8);
}

TEST_CASE("haply: lying device: noise on one encoder is found", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  w.bench.emulated().lie(HaplyFault::kNoise);
  check_found(w, kDeviceNoisy);
}

TEST_CASE("haply: lying device: once it is honest again the driver says so", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(500);
  w.bench.emulated().lie(GENERATE(HaplyFault::kFrozen, HaplyFault::kOldFirst, HaplyFault::kDelayed,
                                  HaplyFault::kNoise));
  w.run(200);
  REQUIRE((w.state.flags & kDoubt) != 0);
  w.bench.emulated().lie(HaplyFault::kHealthy);
  w.run(1200);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.torque() > 0.01);
}

TEST_CASE(
    "haply: lying device: a flipped encoder, or counts that stand still, drive nothing "
    "beyond the limits",
    "[device-io]") {
  // honest to the protocol; the hand's motion is wrong, and the limits hold all the same
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  w.bench.emulated().lie(GENERATE(HaplyFault::kFlipped, HaplyFault::kFrozenCounts));
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    most = std::max(most, w.torque());
  }
  CHECK(std::isfinite(norm(w.state.X_BH.p)));
  CHECK(most <= 0.123 * 1.0001);
}

TEST_CASE("haply: silent, it is lost within 22 ms, and pushes no more when it is back",
          "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  w.bench.emulated().lie(HaplyFault::kSilent);
  const int found = w.ticks_until(kDeviceLost, 100);
  CHECK(found > 0);
  CHECK(found <= 22);
  w.run(300);
  // without a watchdog it has held its torques; what waits for it ends with zero
  w.bench.emulated().lie(HaplyFault::kHealthy);
  w.bench.pass(w.t_ns + 2 * kMs);
  CHECK(w.torque() == 0);
  w.run(400);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.torque() > 0.01);
}

TEST_CASE("haply: lost bytes cost samples, not sense", "[device-io]") {
  EmulatedHaplyOptions options = pressing("typical", 0.008);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(1100);
  const double settled = w.state.X_BH.p.y;
  w.bench.emulated().lie(HaplyFault::kLoses);
  double farthest = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    farthest = std::max(farthest, std::fabs(w.state.X_BH.p.y - settled));
  }
  CHECK(farthest < 0.002);
  CHECK((w.seen & kDoubt) == 0);
}

TEST_CASE("haply: an honest board behind a busy machine is believed, however late it is",
          "[device-io]") {
  // each way, up to the allowed silence; constant or random
  const int most_ms = GENERATE(1, 3, 6, 8), by_chance = GENERATE(0, 1);
  Wall w(pressing("stiff-arm", 0.003));
  w.run(200);
  std::mt19937 random(5);
  int lost = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i % 7 == 0) {
      const double share = by_chance != 0 ? std::uniform_real_distribution<>(0.1, 1)(random) : 1;
      w.bench.delay_ns = static_cast<int64_t>(share * static_cast<double>(most_ms * kMs));
    }
    w.step();
    lost += (w.state.flags & kDeviceLost) != 0;
  }
  CAPTURE(most_ms, by_chance, lost);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(lost == 0);
}

TEST_CASE("haply: the zero of hapticd lets go, and its answers are no lie", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  REQUIRE(w.torque() > 0.01);
  const DeviceRelease release = w.bench.release();
  CHECK(release.by == static_cast<uint32_t>(ReleaseBy::kWrite));
  const EmulatedHaply::Bytes zero(release.bytes.begin(), release.bytes.begin() + release.size);
  CHECK(zero ==
        EmulatedHaply::Bytes{3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 0x11, 0, 0, 0, 0, 0, 0, 0, 0});
  for (int i = 0; i < 4; ++i) {
    w.bench.send(zero);
    w.bench.pass(w.t_ns += 5 * kMs);
    CHECK(w.torque() == 0);
  }
  w.run(100);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.bench.emulated().setups() == 1);
  CHECK(w.bench.emulated().resets() == 1);
  CHECK(w.torque() > 0.01);
}

TEST_CASE("haply: half a question, then the zeros of hapticd: it lets go all the same",
          "[device-io]") {
  // a program is killed in the middle of a question, after any byte
  const size_t cut = GENERATE(range<size_t>(1, 12));
  Wall w(pressing("typical", 0.008));
  w.run(300);
  const HaplyQuestion question = encode_haply(0x38, 12'000, 12'000);
  const DeviceRelease release = w.bench.release();
  w.bench.send({question.begin(), question.begin() + static_cast<ptrdiff_t>(cut)});
  w.bench.pass(w.t_ns += 5 * kMs);
  w.bench.send({release.bytes.begin(), release.bytes.begin() + release.size});
  w.bench.pass(w.t_ns += 5 * kMs);
  CAPTURE(cut);
  CHECK(w.torque() == 0);
  w.run(300);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.bench.emulated().setups() == 1);
  CHECK(w.bench.emulated().resets() == 1);
}

TEST_CASE("haply: a wrench that is not finite is no force", "[device-io]") {
  Wall w(pressing("typical", 0.008));
  w.run(1100);
  REQUIRE(w.torque() > 0.01);
  w.t_ns += kMs;
  w.bench.read({w.t_ns, w.t_ns}, w.state);
  w.bench.write({{0, std::nan(""), 0}, {}});
  w.bench.pass(w.t_ns + kMs);
  CHECK(w.torque() == 0);
}
