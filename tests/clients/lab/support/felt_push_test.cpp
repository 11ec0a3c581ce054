// SPDX-License-Identifier: GPL-3.0-or-later
// What pushes a body is what the hand feels: judged by the force that the device was told and by
// the momentum that the bodies have, whatever safety makes of what was rendered.
#include <catch2/catch.hpp>
#include <cmath>

#include "proto/math/units.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A hand that nothing stops, which goes its way [m] at a time [s]; sums up what it is told.
class LedHand : public Device {
 public:
  explicit LedHand(std::function<Vec3(double)> way, uint32_t flags = 0)
      : way_(std::move(way)), flags_(flags) {}

  DeviceCaps caps() const override { return {100, 0, false, true}; }
  std::string description() const override { return "led"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    const double t = kTick * ticks_++;
    state = {};
    state.t_ns = tick.deadline_ns;
    state.X_BH.p = way_(t);
    state.V_BH.v = (way_(t) - way_(t - kTick)) / kTick;
    state.flags = kDeviceFresh | kDeviceHomed | kDeviceSimulated | flags_;
    return true;
  }
  void write(const Wrench& F_B) override { given_B_ += -kTick * F_B.f, largest_ = norm(F_B.f); }
  void stop() override {}
  Vec3 given() const { return given_B_; }  // impulse on the scene, in device units [N·s]
  double force() const { return largest_; }

 private:
  std::function<Vec3(double)> way_;
  uint32_t flags_;
  int ticks_ = 0;
  Vec3 given_B_;
  double largest_ = 0;
};

/// Two heavy boxes, a millimetre apart, that make a corner for a sphere: one from x = 0 on, one
/// from y = 0 on.
struct TwoBoxes : PushedSession {
  static constexpr double kMass = 10, kRadius = 0.005;
  TwoBoxes() : PushedSession(0, 2000) {
    config.n_objects = 0;
    owned.clear();
    shapes.clear();
    config.renderer = Renderer::kVirtualProxy3;
    config.proxy_radius = kRadius;
    add_box({0.02, 0.3, 0.3}, {0.01, -0.15, 0}, kMass);
    add_box({0.3, 0.02, 0.3}, {-0.151, 0.01, 0}, kMass);
  }
};

/// Into the corner between the two, deeper along x, and out again.
Vec3 into_corner(double t) {
  const double s = std::sin(kPi * std::clamp(t / 0.8, 0.0, 1.0));
  return Vec3{-0.007, -0.007, 0} + s * s * Vec3{0.008, 0.005, 0};
}

Vec3 momentum(const Lockstep& lockstep) {
  Vec3 sum;
  for (size_t i = 0; i < 2; ++i) sum += TwoBoxes::kMass * lockstep.scene().objects[i].V_WO.v;
  return sum;
}

}  // namespace

TEST_CASE("felt push: bodies get what the device was told, over the force scale", "[pushed]") {
  const double scale = GENERATE(0.5, 1.0, 3.0);
  TwoBoxes session;
  session.config.map.force_scale = scale;
  double largest = 100, softly = 0;
  SECTION("as it is rendered") {}
  SECTION("saturated") {
    largest = 2;
  }
  SECTION("while the force begins softly") {
    softly = 1;
  }
  SECTION("slewed") {
    session.config.safety.slew = 5;
    session.config.coupling.translational_stiffness = 200;
  }
  SECTION("hot") {
    session.config.device.continuous_force = 0.5;
    largest = 3;
  }
  session.config.safety.max_force = largest;
  session.config.safety.soft_start = softly;
  LedHand hand(into_corner);
  Lockstep lockstep(session.config, session.shapes, hand);
  double most = 0;
  for (int k = 0; k < 900; ++k) {
    REQUIRE(lockstep.step());
    most = std::max(most, hand.force());
  }
  const Vec3 has = momentum(lockstep), given = hand.given() / scale;
  CAPTURE(scale, has.x, has.y, given.x, given.y, most);
  CHECK(most > 0.3);
  CHECK(norm(given) > 0.1);
  CHECK(norm(has - given) <= 0.01 * norm(given));
}

TEST_CASE("felt push: the edge of the workspace and the damper push nothing", "[pushed]") {
  TwoBoxes session;
  session.config.safety.max_force = 20;
  SECTION("edge") {
    // it pushes the hand along z only, and touches nothing
    session.config.device.workspace_centre_B = {0, 0, -0.1};
    session.config.device.workspace_radius = 0.09;
    LedHand hand([](double t) { return into_corner(t) + Vec3{0, 0, 0.002}; }, kDeviceOpenLoop);
    Lockstep lockstep(session.config, session.shapes, hand);
    for (int k = 0; k < 900; ++k) REQUIRE(lockstep.step());
    const Vec3 has = momentum(lockstep), given = hand.given();
    CAPTURE(has.x, has.y, has.z, given.x, given.y, given.z);
    CHECK(std::fabs(given.z) > 1);
    CHECK(std::fabs(has.z) < 1e-3);
    CHECK(has.x > 0.1);
  }
  SECTION("damper") {
    // a hand that trembles against a stiff wall: what it feels beyond the spring is not the body's
    session.config.device.max_damping = 20;
    const auto trembles = [](double t) {
      return Vec3{1e-3 * std::sin(2 * kPi * 120 * t) - 0.004, -0.05, 0};
    };
    LedHand hand(trembles);
    Lockstep lockstep(session.config, session.shapes, hand);
    double spring = 0;
    bool damped = false;
    for (int k = 0; k < 300; ++k) {
      REQUIRE(lockstep.step());
      spring += kTick * std::min(-lockstep.frame().F_coupling_W.f.x, 20.0);
      damped |= (lockstep.frame().flags & kServoPassivity) != 0;
    }
    CAPTURE(momentum(lockstep).x, spring, hand.given().x);
    CHECK(damped);
    CHECK(momentum(lockstep).x <= 1.001 * spring);
  }
}
