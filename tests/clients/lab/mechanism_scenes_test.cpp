// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes with mechanisms, played in lockstep by the hand of their demo.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "clients/lab/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/device.h"
#include "tests/support/data.h"

using namespace haptic;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A shipped scene with its hand.
struct Demo {
  explicit Demo(const std::string& name)
      : config(load_config(test::from_source("configs/" + name + ".toml"))),
        baked(bake_session(config)),
        hand(open_device(config.device)),
        lockstep(config, baked.shapes(), *hand) {}

  /// Plays for so many seconds, or until the hand has ended; `look` is called after each tick.
  void play(double seconds, const std::function<void()>& look) {
    for (int k = 0; 1e-3 * k < seconds && lockstep.step(); ++k) {
      const double force = norm(lockstep.frame().F_device_B.f);
      REQUIRE(force <= config.safety.max_force * (1 + 1e-9));
      most_force = std::max(most_force, force);
      look();
      if ((lockstep.frame().device.flags & kDeviceEnded) != 0) break;
    }
  }
  const JointState& joint(size_t i) const { return lockstep.scene().joints[i]; }

  SessionConfig config;
  BakedSession baked;
  std::unique_ptr<Device> hand;
  Lockstep lockstep;
  double most_force = 0;
};

}  // namespace

TEST_CASE("scene door: opened over both detents and shut into its latch", "[mechanisms]") {
  Demo door("door");
  double widest = 0;
  int open_at_35 = 0, open_at_50 = 0;
  door.play(20, [&] {
    const double q = door.joint(0).position;
    REQUIRE(q >= -1e-9);
    REQUIRE(q <= 72 * kDegree + 1e-9);
    widest = std::max(widest, q);
    if (q > 33 * kDegree && q < 37 * kDegree) ++open_at_35;
    if (q > 48 * kDegree && q < 52 * kDegree) ++open_at_50;
  });
  CAPTURE(widest / kDegree, open_at_35, open_at_50, door.most_force);
  CHECK(widest > 68 * kDegree);
  // the check holds it there for a while
  CHECK(open_at_35 > 2 * open_at_50);
  CHECK(std::fabs(door.joint(0).position) < 0.1 * kDegree);
  CHECK(door.most_force > 2.5);
}

TEST_CASE("scene gear-pair: the turned gear turns the other by the ratio of teeth",
          "[mechanisms]") {
  Demo gears("gear-pair");
  // each tooth is thinner by 0.1 mm along the pitch circle; pieces and triangles add a little
  constexpr double kPlay = 2 * 0.1e-3 + 0.06e-3;
  constexpr double kSmall = 30e-3, kLarge = 45e-3;  // radii of the pitch circles [m]
  double most = 0, least = 0, off = 0;
  gears.play(3.9, [&] {
    const double small = gears.joint(0).position, large = gears.joint(1).position;
    most = std::max(most, small);
    least = std::min(least, small);
    // rolled off on the two circles, in opposite directions
    off = std::max(off, std::fabs(kSmall * small + kLarge * large));
  });
  CAPTURE(most, least, off, gears.most_force);
  CHECK(most - least > 60 * kDegree);
  CHECK(off <= kPlay);
}

TEST_CASE("scene heap: what the hand pushes falls, and nothing falls through", "[mechanisms]") {
  Demo heap("heap");
  heap.play(4, [] {});
  const SceneFrame& scene = heap.lockstep.scene();
  int moved = 0;
  for (uint32_t i = 1; i < heap.config.n_objects; ++i) {
    const Vec3& p = scene.X_WO[i].p;
    CAPTURE(i, p.x, p.y, p.z);
    moved += norm(p - heap.config.objects[i].X_WO.p) > 0.01 ? 1 : 0;
    const bool on_table = std::fabs(p.x) < 0.18 && std::fabs(p.z) < 0.12;
    if (on_table) CHECK(p.y > 4e-3);
  }
  CHECK(moved >= 3);
  // the upper box has come down
  CHECK(scene.X_WO[6].p.y < 0.06);
}
