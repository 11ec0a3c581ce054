// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/rigid_detector.cpp, and for what contact/step.cpp does with it.
#include "contact/detect/rigid_detector.h"

#include <limits>

#include "proto/wire/renderer.h"
#include "tests/support/frames.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/over_block.h"

namespace haptic {
namespace {

using test::IsNear;
using test::Random;

constexpr double kMargin = 1e-6;

/// A small block over a block of 10 cm whose top is at z = 0.
SessionConfig block_over_block(Renderer renderer) {
  SessionConfig config = test::over_block(renderer, test::kCube);
  config.coupling.translational_stiffness = 800;
  config.coupling.rotational_stiffness = 2;
  config.rigid.margin = kMargin;
  return config;
}
constexpr double kRest = 0.01;

struct RigidBench : test::BakedContact {
  ServoFrame servo{};
  std::unique_ptr<ContactSet> set;

  explicit RigidBench(const SessionConfig& session) : BakedContact(session) {
    servo.renderer = static_cast<uint32_t>(config.renderer);
    servo.X_WG.p = {0, 0, 1};
    servo.flags = kServoNoContactSet;
  }

  /// The next tick, with hand and proxy at this pose.
  const ContactSet& answer(const Pose& X_WT) {
    servo.X_WT = servo.X_WP = X_WT;
    return answer();
  }
  const ContactSet& answer(const SceneFrame* scene = nullptr) {
    servo.t_ns += 1'000'000;
    ++servo.tick;
    set = std::make_unique<ContactSet>(contact_step(model, *state, servo, scene));
    servo.X_WG = set->X_WG;
    servo.flags = 0;
    return *set;
  }
  bool is_met(const Pose& X_WT) const {
    for (uint32_t i = 0; i < model.shapes.size(); ++i) {
      const Pose X_OT = inverse(set->objects[i].X_WO) * X_WT;
      if (triangle_pairs(model.shapes[i], model.tool, X_OT, {}) > 0) return true;
    }
    return false;
  }
};

Pose tool_at(double x, double y, double z, const Quat& q = {}) {
  return {{x, y, z}, q};
}

}  // namespace

TEST_CASE("rigid tool: without a tool it is flagged, and nothing is rendered") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  SessionConfig config = block_over_block(renderer);
  config.tool = {};
  RigidBench point(config);
  const ContactSet& set = point.answer(tool_at(0, 0, 0.02));
  CHECK((set.flags & kContactNoDetector) != 0);
  CHECK((set.flags & kContactNoFreePose) != 0);
  CHECK(set.contacts.size() == 0);
}

TEST_CASE("rigid tool: a hand in a block has its tool rest on it") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidBench bench(block_over_block(renderer));
  const ContactSet& free = bench.answer(tool_at(0, 0, 0.03));
  CHECK(free.flags == 0);
  CHECK(free.reseeds == 0);
  CHECK(free.n_active == 0);
  CHECK(free.tool.mass == 0.05);
  CHECK_THAT(free.X_WG.p, IsNear({0, 0, 0.03}, 0));
  for (int tick = 0; tick < 20; ++tick) {
    const Pose hand = tool_at(1e-3 * tick, 0, 0.005, from_rotation_vector({0, 0, 0.01 * tick}));
    const ContactSet& set = bench.answer(hand);
    CAPTURE(tick, set.flags, set.contacts.size());
    CHECK(set.flags == 0);
    CHECK(set.renderer == static_cast<uint32_t>(renderer));
    CHECK_FALSE(bench.is_met(set.X_WG));
    CHECK_THAT(set.X_WT.p, IsNear(hand.p, 0));
    CHECK_THAT(set.X_WG.p, IsNear({hand.p.x, 0, kRest + kMargin}, 0.2 * kMargin));
    REQUIRE(set.n_active > 0);
    REQUIRE(set.n_active <= set.contacts.size());
    CHECK(set.contacts[0].normal_O.z > 0.999);
    CHECK(set.reseeds == 0);
  }
}

TEST_CASE(
    "rigid tool: constrained dynamics lead it to the servo's proxy, the god-object to the "
    "hand where nothing holds it back") {
  for (const Renderer renderer : {Renderer::kGodObject6, Renderer::kConstrained6}) {
    for (const double friction : {0.0, 0.5}) {
      SessionConfig config = block_over_block(renderer);
      config.objects[0].material.friction_static = friction;
      RigidBench bench(config);
      bench.servo.X_WT = tool_at(0, 0, 0.03);
      bench.servo.X_WP = tool_at(0.01, 0, 0.03);
      const bool by_servo = renderer == Renderer::kConstrained6 || friction > 0;
      const Pose led = by_servo ? bench.servo.X_WP : bench.servo.X_WT;
      const ContactSet& set = bench.answer();
      CAPTURE(set.renderer, friction);
      CHECK(set.X_WT.p == led.p);
      CHECK_THAT(set.X_WG.p, IsNear(led.p, kMargin));
    }
  }
}

TEST_CASE("rigid tool: what begins inside is placed where it is free, and that is said") {
  RigidBench bench(block_over_block(Renderer::kGodObject6));
  const ContactSet& set = bench.answer(tool_at(0.002, 0.001, 0.003));
  CHECK((set.flags & kContactReseeded) != 0);
  CHECK((set.flags & kContactNoFreePose) == 0);
  CHECK(set.reseeds == 1);
  CHECK_FALSE(bench.is_met(set.X_WG));
  const ContactSet& next = bench.answer(tool_at(0.002, 0.001, 0.003));
  CHECK((next.flags & kContactReseeded) == 0);
  CHECK(next.reseeds == 1);
  CHECK_FALSE(bench.is_met(next.X_WG));
}

TEST_CASE("rigid tool: while the force is closed it is where the hand is, if it is free there") {
  RigidBench bench(block_over_block(Renderer::kGodObject6));
  bench.answer(tool_at(0, 0, 0.03));
  // through the block: no contacts, no force
  for (const double z : {0.02, 0.0, -0.05, -0.2}) {
    bench.servo.flags = kServoPaused;
    const ContactSet& set = bench.answer(tool_at(0, 0, z));
    CAPTURE(z);
    const bool is_free = z == 0.02 || z == -0.2;
    CHECK(((set.flags & kContactNoFreePose) == 0) == is_free);
    CHECK(set.X_WG.p == Vec3{0, 0, z});
    if (!is_free) CHECK(set.contacts.size() == 0);
  }
  // from below: it stays below
  const ContactSet& set = bench.answer(tool_at(0, 0, -0.05));
  CHECK(set.X_WG.p.z <= -0.11);
  CHECK((set.flags & kContactReseeded) == 0);
}

TEST_CASE("rigid tool: a contact that was started anew takes it up where the servo has it") {
  RigidBench first(block_over_block(Renderer::kGodObject6));
  first.answer(tool_at(0, 0, 0.03));
  const Pose rest = first.answer(tool_at(0, 0, -0.03)).X_WG;
  RigidBench anew(block_over_block(Renderer::kGodObject6));
  anew.servo = first.servo;
  const ContactSet& set = anew.answer();
  CHECK((set.flags & (kContactReseeded | kContactNoFreePose)) == 0);
  CHECK_THAT(set.X_WG.p, IsNear(rest.p, 0.2 * kMargin));
  // without any previous answer it begins where the hand is
  RigidBench blank(block_over_block(Renderer::kGodObject6));
  blank.servo = first.servo;
  blank.servo.flags = kServoNoContactSet;
  CHECK((blank.answer().flags & kContactReseeded) != 0);
  // and a pose that is not finite is not taken over
  RigidBench broken(block_over_block(Renderer::kGodObject6));
  broken.servo = first.servo;
  broken.servo.X_WG.p.x = std::numeric_limits<double>::quiet_NaN();
  const ContactSet& found = broken.answer();
  CHECK(is_finite(found.X_WG));
  CHECK((found.flags & kContactReseeded) != 0);
  CHECK_FALSE(broken.is_met(found.X_WG));
}

TEST_CASE("rigid tool: another renderer while it runs begins anew, at the same place") {
  RigidBench bench(block_over_block(Renderer::kGodObject6));
  bench.answer(tool_at(0, 0, 0.03));
  const Pose rest = bench.answer(tool_at(0, 0, 0.0)).X_WG;
  for (const Renderer renderer :
       {Renderer::kConstrained6, Renderer::kDirect6, Renderer::kGodObject6, Renderer::kGodObject3,
        Renderer::kConstrained6}) {
    const uint64_t before = bench.set->reseeds;
    bench.servo.renderer = static_cast<uint32_t>(renderer);
    const ContactSet& set = bench.answer(tool_at(0, 0, 0.0));
    CAPTURE(set.renderer, set.flags);
    CHECK(set.reseeds == before + 1);
    if (!is_rigid(renderer)) continue;
    CHECK_FALSE(bench.is_met(set.X_WG));
    CHECK((set.flags & kContactNoFreePose) == 0);
    if (bench.set->reseeds == 1) CHECK_THAT(set.X_WG.p, IsNear(rest.p, 0.5 * kMargin));
  }
}

TEST_CASE("rigid tool: poses that are no numbers are flagged, and the step after recovers") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Pose& bad :
       {tool_at(nan, 0, 0.02), tool_at(0, 0, std::numeric_limits<double>::infinity()),
        tool_at(0, 0, 0.02, {nan, 0, 0, 1})}) {
    RigidBench bench(block_over_block(Renderer::kGodObject6));
    bench.answer(tool_at(0, 0, 0.03));
    const Pose rest = bench.answer(tool_at(0, 0, 0.005)).X_WG;
    const ContactSet& set = bench.answer(bad);
    CHECK((set.flags & kContactNoFreePose) != 0);
    CHECK(set.contacts.size() == 0);
    const ContactSet& next = bench.answer(tool_at(0, 0, 0.005));
    CHECK((next.flags & kContactNoFreePose) == 0);
    CHECK_THAT(next.X_WG.p, IsNear(rest.p, 0.5 * kMargin));
  }
}

TEST_CASE("rigid tool: shaken among objects that move, what is published meets none of them",
          "[trap]") {
  SessionConfig config = block_over_block(Renderer::kGodObject6);
  config.n_objects = 2;
  config.objects[1] = config.objects[0];
  config.objects[1].primitive = primitive::Box{{0.03, 0.03, 0.03}};
  config.objects[1].X_WO.p = {0.02, 0, 0.02};
  RigidBench bench(config);
  Random random(1);
  Pose hand = tool_at(-0.02, 0, 0.03);
  SceneFrame scene{};
  for (uint32_t i = 0; i < 2; ++i) {
    scene.objects.push_back(test::scene_object(config.objects[i].X_WO));
  }
  size_t n_held = 0, n_free = 0;
  for (size_t tick = 0; tick < test::trials(2000); ++tick) {
    const double t = 1e-3 * static_cast<double>(tick);
    const Pose X{{0.02 + 0.01 * std::sin(3 * t), 0, 0.02 + 0.003 * std::sin(5 * t)},
                 from_rotation_vector({0, 0.3 * std::sin(4 * t), 0})};
    scene.objects[1].X_WO = X;
    test::set_time(scene, bench.servo.t_ns + 1'000'000);
    const Vec3 turn = random.uniform(0, 0.1) * random.direction();
    hand = {hand.p + random.uniform(0, 1.5e-3) * random.direction() +
                0.03 * (Vec3{0, 0, 0.008} - hand.p),
            normalized(from_rotation_vector(turn) * hand.q)};
    bench.servo.X_WT = bench.servo.X_WP = hand;
    const ContactSet& set = bench.answer(&scene);
    CAPTURE(tick, set.flags, set.contacts.size(), set.X_WG.p);
    if ((set.flags & kContactNoFreePose) != 0) continue;
    ++n_free;
    n_held += set.n_active > 0 ? 1 : 0;
    REQUIRE_FALSE(bench.is_met(set.X_WG));
    for (uint32_t i = 0; i < set.contacts.size(); ++i) {
      const Contact& c = set.contacts[i];
      const Pose& X_WO = set.objects[c.object].X_WO;
      const Vec3 apart_W = set.X_WG * c.tool_point_T - X_WO * c.object_point_O;
      const double gap = dot(rotate(X_WO.q, c.normal_O), apart_W);
      REQUIRE(norm(c.normal_O) == Approx(1));
      // the margin belongs to the object: beyond it is not inside
      REQUIRE(gap > -kMargin);
      // along the normal, with no tangential part
      REQUIRE(norm(apart_W - gap * rotate(X_WO.q, c.normal_O)) < 1e-9);
      const bool is_settled = (set.flags & kContactIterationLimit) == 0;
      if (i < set.n_active && is_settled) REQUIRE(gap <= kMargin);
    }
  }
  CHECK(n_free > test::trials(2000) / 2);
  CHECK(n_held > test::trials(2000) / 10);
}

TEST_CASE(
    "rigid tool: crushed it is behind, then not felt, and begins at the hand only after half a "
    "second",
    "[trap]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  SessionConfig config = block_over_block(renderer);
  config.n_objects = 2;
  config.objects[1] = config.objects[0];
  config.objects[1].primitive = primitive::Box{{0.1, 0.1, 4e-3}};
  config.objects[1].X_WO.p.z = 30e-3;
  RigidBench bench(config);
  SceneFrame scene{};
  for (uint32_t i = 0; i < 2; ++i) {
    scene.objects.push_back(test::scene_object(config.objects[i].X_WO));
  }
  const auto step = [&](const Pose& hand) -> const ContactSet& {
    test::set_time(scene, bench.servo.t_ns + 1'000'000);
    bench.servo.X_WT = bench.servo.X_WP = hand;
    return bench.answer(&scene);
  };
  step(tool_at(0, 0, 0.011));
  // the lid comes down on the tool of 20 mm, to 15 mm above the block
  int behind = 0, closed = 0;
  for (int tick = 0; tick < 400; ++tick) {
    if (scene.objects[1].X_WO.p.z > 17e-3) scene.objects[1].X_WO.p.z -= 0.1e-3;
    const ContactSet& set = step(tool_at(0, 0, 0.012));
    if ((set.flags & kContactNoFreePose) != 0) {
      ++closed;
      CHECK(set.contacts.size() == 0);
      continue;
    }
    CHECK(closed == 0);
    // the poses of the objects at which the tool is free of them
    REQUIRE_FALSE(bench.is_met(set.X_WG));
    if (set.objects[1].X_WO == scene.objects[1].X_WO) continue;
    ++behind;
    CHECK((set.flags & kContactIterationLimit) != 0);
    CHECK(set.objects[1].X_WO.p.z > scene.objects[1].X_WO.p.z);
  }
  CHECK(behind == 20);
  REQUIRE(closed > 100);
  // beyond the lid the hand is free, but no path leads there
  const Pose beyond = tool_at(0, 0, 0.05);
  const uint64_t reseeds = bench.set->reseeds;
  int waited = 0;
  while ((step(beyond).flags & kContactNoFreePose) != 0 && waited < 1000) ++waited;
  CHECK(closed + waited == 500);
  CHECK((bench.set->flags & kContactReseeded) != 0);
  CHECK(bench.set->reseeds > reseeds);
  CHECK(step(beyond).X_WG.p == beyond.p);
}

}  // namespace haptic
