// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a Polhem and an emulated one on virtual time, known to each other by their bytes.
#include "device-io/polhem/polhem.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "device-io/hand/impedance.h"
#include "tests/support/emulated_arm.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using EmulatedPolhem = haptic::test::EmulatedArm<Polhem>;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStart = 1'000 * kMs;  // of the ticks
constexpr double kStiffness = 400;       // of the wall, as in configs/polhem.toml [N/m]
constexpr int kFoundWithin = 100;        // [ticks]
constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;

/// A hand of this kind that aims `press` below the middle, with a tremor of 0.1 mm, and turns the
/// handle about by `turn`. Mass, damping and friction are guesses, as in configs/polhem.toml.
EmulatedDeviceOptions pressing(const char* hand, double press, double turn = 0) {
  EmulatedDeviceOptions options;
  options.arm = &polhem_arm();
  options.hand.mass = 0.3;
  options.hand.damping = 0.3;
  options.hand.coulomb_friction = 0.2;
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand(hand), options.hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {0, 0, -press};
  intent.direction_B = {0, 0, 1};
  intent.hover_radius = intent.press_radius = intent.stroke_angle = 0;
  intent.tremor_amplitude = 1e-4;
  intent.turn_angle = turn;
  return options;
}

/// A wall at z = 0 under the hand.
struct Wall {
  EmulatedPolhem device;
  double stiffness = kStiffness;
  Vec3 torque_B;  // beside the wall's force [N·m]
  DeviceState state{};
  int tick = 0;
  uint32_t seen = 0;  // flags so far

  explicit Wall(const EmulatedDeviceOptions& options) : device(options) {}

  void step() {
    const int64_t t_ns = kStart + tick++ * kMs;
    device.read({t_ns, t_ns}, state);
    seen |= state.flags;
    const bool closed = (state.flags & (kDeviceLost | kDoubt)) != 0;
    device.write({{0, 0, closed ? 0 : -stiffness * std::min(0.0, state.X_BH.p.z)}, torque_B});
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
  int32_t largest_current() const {
    const auto& i = device.driver().currents();
    return std::max({std::abs(i[0]), std::abs(i[1]), std::abs(i[2])});
  }
  /// Of the force on the hand, over so many ticks [N].
  double swing(int ticks) {
    double least = 1e9, most = -1e9;
    for (int i = 0; i < ticks; ++i) {
      step();
      least = std::min(least, device.board().record().force_B.z);
      most = std::max(most, device.board().record().force_B.z);
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
  CHECK(w.largest_current() == 0);
}

}  // namespace

TEST_CASE("polhem driver: pose and velocity follow a hand that turns the handle", "[device-io]") {
  EmulatedDeviceOptions options = pressing("typical", 0, 0.6);
  options.hand.intent.centre_B = {0.02, 0.04, 0.01};
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.stiffness = 0;
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    const HandPlant before = w.device.board().plant();
    w.step();
    if (i < 100) continue;
    const double speed = norm(before.w_B);
    // a tick old; a count of the gimbal is 6 mrad, and there are three of them
    const Quat off = w.state.X_BH.q * conjugate(before.q_B);
    REQUIRE(norm(to_rotation_vector(off)) < 0.02 + 2.5e-3 * speed);
    REQUIRE(norm(w.state.X_BH.p - before.p_B) < 3e-4);
    fastest = std::max(fastest, speed);
  }
  CHECK(fastest > 1);
  CHECK((w.seen & kDoubt) == 0);
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
}

TEST_CASE("polhem driver: the hand gets the force, and torque is dropped and said", "[device-io]") {
  Wall w(pressing("stiff-arm", 0.008));
  w.torque_B = {10, -20, 30};
  w.run(2000);
  const double commanded = -kStiffness * w.state.X_BH.p.z;
  REQUIRE(commanded > 1);
  CHECK_THAT(w.device.board().record().force_B, IsNear({0, 0, commanded}, 0.05));
  CHECK((w.seen & kDeviceSaturated) == 0);
  CHECK(w.device.caps().max_torque == 0);
  CHECK(w.device.caps().max_force == 5);
  CHECK(w.device.description().find("6 axes, 3 of them driven (torque is dropped)") !=
        std::string::npos);
}

TEST_CASE("polhem driver: force beyond the device is shortened, and keeps its direction",
          "[device-io]") {
  Wall w(pressing("stiff-arm", 0));
  w.run(50);
  const int64_t t_ns = kStart + w.tick++ * kMs;
  w.device.read({t_ns, t_ns}, w.state);
  w.device.write({{30, 0, 40}, {}});
  w.device.pass(t_ns + kMs);
  CHECK_THAT(w.device.board().record().force_B, IsNear({3, 0, 4}, 0.1));
  w.device.read({t_ns + kMs, t_ns + kMs}, w.state);
  CHECK((w.state.flags & kDeviceSaturated) != 0);
  w.device.write({{std::numeric_limits<double>::infinity(), 0, 0}, {}});
  CHECK(w.largest_current() == 0);
}

TEST_CASE("polhem driver: five hands on a wall of 400 N/m through its bytes: no limit cycle",
          "[device-io]") {
  const char* const hand = GENERATE("none", "light-grip", "typical", "firm", "stiff-arm");
  EmulatedDeviceOptions options = pressing(hand, 0.01);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(2000);
  const double swing = w.swing(1000);
  CAPTURE(hand, swing);
  // a count at the handle is up to 50 µm, 20 mN at this stiffness
  CHECK(swing < 0.06);
}

TEST_CASE("polhem driver: a wall far too stiff is a limit cycle, so that it would be seen",
          "[device-io]") {
  EmulatedDeviceOptions options = pressing("light-grip", 0.01);
  options.hand.intent.tremor_amplitude = 0;
  options.hand.coulomb_friction = 0;
  Wall w(options);
  w.stiffness = 8000;
  w.run(2000);
  CHECK(w.swing(1000) > 1);
}

TEST_CASE("polhem driver: lying device: frozen or old answers are found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100 + GENERATE(0, 13));
  REQUIRE(w.largest_current() > 200);
  REQUIRE((w.seen & kDoubt) == 0);
  w.device.board().lie(
      GENERATE(EmulatorFault::kFrozen, EmulatorFault::kOldFirst, EmulatorFault::kDelayed));
  check_found(w, kDeviceStale);
}

TEST_CASE("polhem driver: lying device: noise on a motor or in the gimbal is found",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.device.board().lie(GENERATE(EmulatorFault::kNoise, EmulatorFault::kTurnNoise));
  check_found(w, kDeviceNoisy);
}

TEST_CASE("polhem driver: lying device: once it is honest again the driver says so",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(500);
  w.device.board().lie(GENERATE(EmulatorFault::kFrozen, EmulatorFault::kOldFirst,
                                EmulatorFault::kDelayed, EmulatorFault::kNoise,
                                EmulatorFault::kTurnNoise));
  w.run(200);
  REQUIRE((w.state.flags & kDoubt) != 0);
  w.device.board().lie(EmulatorFault::kHealthy);
  w.run(1000);
  CHECK((w.state.flags & (kDoubt | kDeviceLost)) == 0);
  CHECK(w.largest_current() > 200);
}

TEST_CASE(
    "polhem driver: lying device: an encoder that slips or counts backwards drives nothing "
    "beyond the limits",
    "[device-io]") {
  // honest to the protocol; the hand's motion is wrong, and the limits hold all the same
  const bool flips = GENERATE(false, true);
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  const int32_t mirror = w.device.board().record().counts[1];
  int32_t most = 0;
  for (int i = 0; i < 2000; ++i) {
    const int32_t off = flips ? 2 * (mirror - w.device.board().record().counts[1]) : 3000;
    w.device.board().disturb({0, off, 0, 0, 0, 0}, std::numeric_limits<uint64_t>::max());
    w.step();
    most = std::max(most, w.largest_current());
    REQUIRE(is_finite(w.state.X_BH.p));
  }
  CHECK(most <= 3000);
}

TEST_CASE("polhem driver: what lets go of it is a zero for each motor", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(500);
  const DeviceRelease release = w.device.driver().release();
  CHECK(std::string_view(release.bytes.data(), release.size) == "[0,0,0]\n");
}
