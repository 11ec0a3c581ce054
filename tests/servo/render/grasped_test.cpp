// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/render/grasped.cpp: how a grasp is let in, falls while nobody moves the body, and
// is over.
#include "servo/render/grasped.h"

#include <catch2/catch.hpp>

#include "proto/wire/guide.h"
#include "proto/wire/renderer.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A point 10 mm from where three guide rows hold it, at the origin of object 0.
struct HeldPoint {
  ServoModel model = plain_model(800);
  std::unique_ptr<ContactSet> set = std::make_unique<ContactSet>();
  TickScene scene;
  GraspState state;
  Vec3 hand{0.01, 0, 0};

  HeldPoint() {
    set->renderer = static_cast<uint32_t>(Renderer::kGodObject3);
    set->objects.resize(1);
    scene.X_WO.resize(1);
    scene.V_WO.resize(1);
    const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (uint32_t i = 0; i < 3; ++i) {
      GuideRow row{};
      row.normal_O = axes[i];
      row.row = i;
      set->guides.push_back(row);
    }
  }
  Hold tick(bool is_wanted, bool stands = false) {
    RenderQuestion question{*set, scene, model.coupling, {}, {}, std::nullopt, 0, std::nullopt};
    question.X_WT.p = hand;
    return hold_of(model, state, question, {is_wanted, stands});
  }
  /// Ticks until the share is what is asked for.
  int ticks_until(double share, bool stands) {
    int n = 1;
    while (std::fabs(tick(true, stands).share - share) > 1e-9 && n < 1000) ++n;
    return n;
  }
};

}  // namespace

TEST_CASE("grasped: a grasp is let in within 200 ms, as a share that grows by each tick") {
  HeldPoint point;
  CHECK_FALSE(point.tick(false).holds());
  const Hold first = point.tick(true);
  CHECK(first.holds());
  CHECK(first.share == Approx(1e-3 / 0.2));
  CHECK(norm(first.X_WP.p) < 1e-12);
  CHECK(point.ticks_until(1, false) == 199);
  point.scene.weight = 0.25;  // of contacts that are late
  CHECK(point.tick(true).share == Approx(0.25));
}

TEST_CASE("grasped: while no sim moves the body the hold pulls as hard as it did") {
  HeldPoint point;
  point.ticks_until(1, false);
  const Vec3 held = point.tick(true).F_W.f;
  CHECK(norm(held) > 1);
  for (int k = 0; k < 300; ++k) CHECK(norm(point.tick(true, true).F_W.f - held) < 1e-12);
  // the hand goes away, and the hold no harder after it
  point.hand.x += 0.05;
  for (int k = 0; k < 300; ++k) {
    CHECK(norm(point.tick(true, true).F_W.f) == Approx(norm(held)));
  }
  // it comes half way back to where the hold is slack: the pull falls, and grows again no further
  const Vec3 away = point.hand;
  const double stiffness = point.model.coupling.translational_stiffness;
  point.hand.x -= 0.5 * norm(held) / stiffness;
  CHECK(norm(point.tick(true, true).F_W.f) == Approx(0.5 * norm(held)));
  point.hand = away;
  CHECK(norm(point.tick(true, true).F_W.f) == Approx(norm(held)));
  // sim is back: what it has given way by is taken up, at 50 mm/s after a tenth of a second of
  // 0.5 m/s²
  const double K = point.model.coupling.translational_stiffness;
  for (int k = 1; k <= 200; ++k) {
    const double t = 1e-3 * k, way = t < 0.1 ? 0.25 * t * t : 2.5e-3 + 0.05 * (t - 0.1);
    CHECK(norm(point.tick(true).F_W.f) == Approx(norm(held) + K * way).margin(K * 30e-6));
  }
}

TEST_CASE("grasped: a body that stands from the first tick on is not pulled until it moves") {
  HeldPoint point;
  for (int k = 0; k < 300; ++k) CHECK(norm(point.tick(true, true).F_W.f) == 0);
  const double first = norm(point.tick(true).F_W.f), second = norm(point.tick(true).F_W.f);
  CHECK(first < second);
  CHECK(second < 0.2);
}
