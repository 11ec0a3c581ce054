// SPDX-License-Identifier: GPL-3.0-or-later
// The checks of tools that never enter an object: against planted faults and closed forms, and on
// short sessions.
#include "clients/lab/eval/rigid.h"

#include "clients/lab/support/scan.h"
#include "contact/detect/contact_model.h"
#include "contact/query/proximity/near_front.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr uint64_t kShort = 200;
constexpr WayLeftJudge::Springs kSprings{1000, 2};

/// A session of the god-object on a plate in which `falsify` changes what the check is given for
/// tick 200.
template <class Falsify>
RigidJudge::Found falsified(const Falsify& falsify) {
  const RigidScene scene = box_on_plate();
  RigidJudge judge(scene.object, scene.tool, {kSprings, 1.7e-6});
  const ShakingHand hand(scene.home, scene.shaking, 3);
  run_rigid(
      scene, Renderer::kGodObject6, [&](double t) { return hand.at(t); }, 202, {},
      [&](ServoFrame frame, const ContactSet* set) {
        if (set == nullptr) return;
        auto shown = std::make_unique<ContactSet>(*set);
        if (frame.tick == 200) falsify(frame, *shown);
        judge.add(frame, shown.get());
      });
  return judge.found();
}

}  // namespace

TEST_CASE("eval rigid: what is left of a way above a plane", "[lab]") {
  const RigidScene scene = box_on_plate();
  constexpr double kMargin = 1e-6, kBand = 10e-6;
  WayLeftJudge judge(scene.object, scene.tool, kSprings);
  const Pose touching{{0, 0, 10e-3 + kMargin}, {}};
  CHECK_FALSE(judge.is_entered(touching));
  // straight in: nothing
  WayLeft left = judge.way_left(touching, {{0, 0, 5e-3}, {}}, kMargin, kBand);
  CHECK(left.is_known);
  CHECK(left.rows > 0);
  CHECK(left.length <= tol(1e-12));
  // at an angle: the part along the plane
  left = judge.way_left(touching, {{2e-3, 1e-3, 5e-3}, {}}, kMargin, kBand);
  CHECK_THAT(left.motion.v, IsNear({2e-3, 1e-3, 0}, 1e-11));
  CHECK_THAT(left.motion.w, IsNear({}, 1e-10));
  // away: all of it, including the rotation
  const Vec3 turn{0.1, 0, 0.2};
  left = judge.way_left(touching, {{0, 1e-3, 20e-3}, from_rotation_vector(turn)}, kMargin, kBand);
  CHECK_THAT(left.motion.v, IsNear({0, 1e-3, 10e-3 - kMargin}, 1e-12));
  CHECK_THAT(left.motion.w, IsNear(turn, 1e-12));
  const double squared = norm_squared(left.motion.v) + 2.0 / 1000 * norm_squared(turn);
  CHECK(left.length == Approx(std::sqrt(squared)));
  // beyond the band no constraint is known
  left = judge.way_left({{0, 0, 10.1e-3}, {}}, {}, kMargin, kBand);
  CHECK(left.rows == 0);
  CHECK(left.length == Approx(10.1e-3));
}

TEST_CASE("eval rigid: a pose inside is seen, by its surface or by what holds it", "[lab]") {
  const RigidScene plate = box_on_plate();
  const WayLeftJudge judge(plate.object, plate.tool, kSprings);
  CHECK(judge.is_entered({{0, 0, 10e-3 - 1e-9}, {}}));
  CHECK_FALSE(judge.is_entered({{0, 0, 10e-3 + 1e-9}, {}}));
  const RigidScene held = rigid_scene("held", make_box({1, 1, 1}), make_box({0.1, 0.1, 0.1}));
  CHECK(WayLeftJudge(held.object, held.tool, kSprings).is_entered({}));
  CHECK(WayLeftJudge(held.tool, held.object, kSprings).is_entered({}));
  CHECK_FALSE(WayLeftJudge(held.object, held.tool, kSprings).is_entered({{2, 0, 0}, {}}));
}

TEST_CASE("eval rigid: planted faults are found", "[lab][trap]") {
  const RigidJudge::Found right = falsified([](ServoFrame&, ContactSet&) {});
  REQUIRE(right.felt > 0);
  CHECK(right.inside == 0);
  CHECK(right.off_cone <= 1e-6);
  CHECK(right.beside <= 1e-6);
  CHECK(right.jammed_ticks == 0);
  CHECK(right.jammed_poses == 0);
  CHECK(right.fallen == 0);

  CHECK(falsified([](ServoFrame&, ContactSet& set) { set.X_WG.p.z = 5e-3; }).inside == 1);
  const auto pushed = [](const Wrench& by) {
    return falsified(
        [&](ServoFrame& frame, ContactSet&) { frame.F_coupling_W = frame.F_coupling_W + by; });
  };
  const double force = right.largest_force;
  CHECK(pushed({{0, 0, 3 * force}, {}}).largest_step > 2 * force);
  CHECK(pushed({{0.1 * force, 0, 0}, {}}).beside > 1e-3);
  const auto led = [&](const Vec3& by) {
    return falsified([&](ServoFrame& frame, ContactSet&) { frame.X_WP.p += by; });
  };
  CHECK(led({1e-4 * force, 0, 0}).off_cone > 1e-3);
  CHECK(led({0, 0, -2e-3 * force}).off_cone > 0.1);
  CHECK(falsified([](ServoFrame& frame, ContactSet&) {
          frame.F_coupling_W = {};
          frame.X_WP = frame.X_WT;
        }).fallen == 1);
  CHECK(falsified([](ServoFrame& frame, ContactSet&) {
          frame.F_coupling_W.t.x = std::numeric_limits<double>::quiet_NaN();
        }).not_finite == 1);
  CHECK(falsified([](ServoFrame&, ContactSet& set) {
          set.flags |= kContactReseeded;
        }).placed_anew == 1);
}

TEST_CASE("eval rigid: a tool that is held by nothing is a jam", "[lab][trap]") {
  const RigidScene scene = box_on_plate();
  RigidJudge judge(scene.object, scene.tool, {kSprings, 1e-6});
  auto set = std::make_unique<ContactSet>();
  set->X_WG = scene.home;
  for (int k = 0; k < 10; ++k) {
    ServoFrame frame{};
    frame.X_WP = scene.home;
    frame.X_WT.p = scene.home.p + Vec3{1e-3 * k, 0, 0};
    frame.F_coupling_W.f.x = -1000 * 1e-3 * k;
    set->seq = static_cast<uint64_t>(k);
    set->X_WT = frame.X_WT;
    judge.add(frame, set.get());
  }
  CHECK(judge.found().jammed_poses == 9);
  CHECK(judge.found().jammed_ticks == 9);
  CHECK(judge.found().off_cone == Approx(1));
  const Rows rows;
  judge.add_rows("jam", rows);
  CHECK_FALSE(all_hold(rows.rows()));
}

TEST_CASE("eval rigid: a hand shakes within its bounds", "[lab]") {
  const Pose home{{1, 2, 3}, from_rotation_vector({0, 0, 1})};
  const Shaking shaking{{20e-3, 5e-3, 1e-3}, {0.3, 0, 0.1}, {0, 0, -2e-3}};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const ShakingHand hand(home, shaking, seed);
    CHECK(hand.top_speed() <= 0.5 + tol(1e-12));
    double speed = 0, farthest = 0, beyond = 0;
    for (int k = 0; k < 10'000; ++k) {
      const Pose now = hand.at(1e-3 * k);
      const Vec3 way = now.p - home.p - shaking.press;
      const Vec3 turn = to_rotation_vector(now.q * conjugate(home.q));
      for (int i = 0; i < 3; ++i) {
        beyond = std::max(beyond, std::fabs(way[i]) - shaking.way[i]);
        beyond = std::max(beyond, std::fabs(turn[i]) - shaking.turn[i]);
      }
      farthest = std::max(farthest, std::fabs(way.x));
      speed = std::max(speed, norm(hand.at(1e-3 * (k + 1)).p - now.p) / 1e-3);
    }
    CHECK(beyond <= tol(1e-12));
    CHECK(speed <= hand.top_speed() + tol(1e-12));
    CHECK(farthest > 0.5 * shaking.way.x);
  }
}

TEST_CASE("eval rigid: short sessions hold every goal", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const RigidScene scene = GENERATE(box_on_plate(), peg_in_hole(0.2e-3));
  RigidEval eval;
  eval.ticks = kShort;
  const RigidJudge judge = shake_rigid(scene, renderer, eval);
  CHECK(judge.found().felt > eval.ticks / 10);
  CHECK(judge.found().poses > eval.ticks / 2);
  const Rows rows;
  judge.add_rows(scene.name, rows);
  for (const Row& row : rows.rows()) {
    CAPTURE(row.case_name, row.metric, row.value);
    CHECK(row.holds != false);
  }
}

TEST_CASE("eval rigid: shaken in a tight hole and on a scan nothing meets", "[lab][trap]") {
  std::vector<RigidScene> scenes{peg_in_hole(0.05e-3)};
  if (auto scan = bunny_on_bunny(meshes_folder())) {
    scenes.push_back(*std::move(scan));
  } else {
    // these meshes come from a package; the hole needs none
    WARN("SKIPPED: no scans in HAPTICD_MESHES: `./run meshes` puts them there");
  }
  for (const RigidScene& scene : scenes) {
    const std::array objects{scene.object};
    const std::array<Pose, 1> X_WO{};
    const ToolBody body = tool_body(scene.tool.mesh, {});
    GodObject6 god(objects, scene.tool, body, god_object_options({}, body));
    REQUIRE(god.place(X_WO, scene.home));
    const WayLeftJudge judge(scene.object, scene.tool, kSprings);
    NearFront front(scene.object, scene.tool);
    const ShakingHand hand(scene.home, scene.shaking, 1);
    size_t held = 0;
    const size_t frames = sweep(400);  // 5000 with HAPTIC_TORTURE_SCALE = 12.5
    for (size_t k = 0; k < frames; ++k) {
      const GodObjectMove move = god.move(X_WO, hand.at(1e-3 * static_cast<double>(k)), 0.5e-3);
      held += move.n_active > 0;
      CAPTURE(scene.name, k);
      REQUIRE_FALSE(move.is_lost);
      REQUIRE(front.update(god.X_WG(), 0).empty());
      if (k % 50 == 0) REQUIRE_FALSE(judge.is_entered(god.X_WG()));
    }
    CHECK(2 * held > frames);
  }
}

TEST_CASE("eval rigid: free space and a slanted push on a plane", "[lab]") {
  for (const uint32_t age : {1, 2, 7, 20}) {
    CHECK(force_in_free_space(Renderer::kGodObject6, {1, age}) == 0);
  }
  CHECK(force_in_free_space(Renderer::kConstrained6, {}) > 0);
  CHECK(slant_of_push(Renderer::kGodObject6, {}) <= tol(1e-9));
}
