// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/wire/scene_pose.h"

#include <catch2/catch.hpp>

#include "proto/math/units.h"
#include "tests/support/frames.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr int64_t kTickNs = 1'000'000;

SceneFrame one_object() {
  SceneFrame scene{};
  scene.objects.push_back(test::scene_object(
      {{0.1, -0.2, 0.3}, from_rotation_vector({0.3, 0.1, -0.8})}, {{0.5, -0.1, 0.2}, {1, -2, 3}}));
  test::set_time(scene, 100 * kTickNs);
  return scene;
}

/// A ball of this mass [kg] whose origin is its centre.
void give_mass(SceneFrame& scene, double mass) {
  ObjectResponse& response = test::add_response(scene, 0);
  for (size_t axis = 0; axis < 3; ++axis) response.mobility[7 * axis] = 1 / mass;
}

/// A servo that counts: an impulse falls on the instant of a tick.
struct Counters {
  ServoFrame frame{};

  explicit Counters(int64_t since_ns) {
    frame.t_ns = frame.impulses_since_ns = since_ns;
    frame.pushes.resize(1);
  }
  void push(int64_t t_ns, const Vec3& impulse_W) {
    auto& [J, S] = frame.pushes[0];
    S = S + seconds_of(t_ns - frame.t_ns) * J;
    J.f += impulse_W;
    frame.t_ns = t_ns;
  }
  /// As sim notes it in a scene.
  void seen_by(SceneFrame& scene) const {
    const auto& [J, S] = frame.pushes[0];
    scene.seen[0] = {J, S, {}, frame.t_ns};
  }
};

}  // namespace

TEST_CASE("scene pose: an object that answers no push is where its script puts it, bit for bit",
          "[wire][push]") {
  SceneFrame scene = one_object();
  Counters hand(50 * kTickNs);
  // heavy, or without a response, or with one that is not there, or that has no counters
  const int what = GENERATE(0, 1, 2, 3, 4);
  test::add_response(scene, 0);
  if (what > 0) scene.responses[0].mobility[0] = 1;
  hand.seen_by(scene);
  hand.push(101 * kTickNs, {1, 2, 3});
  if (what == 0) CHECK(seen_of(scene, 0, kFirstHand) == &scene.seen[0]);
  if (what == 1) scene.objects[0].response = kNoResponse;
  if (what == 2) scene.objects[0].response = 1;
  if (what == 3) scene.seen.clear();
  if (what == 4) hand.frame.pushes.clear();
  const int64_t age_ns = GENERATE(-30 * kTickNs, -1234, 0, 7654321, 20 * kTickNs, 90 * kTickNs);
  const int64_t t_ns = scene.t_ns + age_ns;
  CHECK(object_pose_at(scene, 0, t_ns, push_of(hand.frame, kFirstHand)) ==
        object_pose_at(scene, 0, t_ns));
  CHECK(object_twist_at(scene, 0, t_ns, push_of(hand.frame, kFirstHand)) ==
        object_twist_at(scene, 0, t_ns));
}

TEST_CASE("scene pose: a free ball is where the sum of all impulses puts it, whatever sim has seen",
          "[wire][push]") {
  constexpr double kMass = 0.02;              // [kg]
  const int64_t saw = GENERATE(-3, 0, 2, 8);  // tick whose counters sim has used
  const int64_t made = saw + GENERATE(0, 1, 3);
  const auto push_at = [](int64_t k) {
    const auto x = static_cast<double>(k);
    return Vec3{0.01 * std::sin(1 + x), 0.002 * x, -0.003};
  };

  // by definition: each impulse changes the velocity from its own instant on
  const auto truth = [&](int64_t t_ns, int64_t until) {
    Vec3 p_W{0.1, 0, 0};
    for (int64_t k = -5; k <= until; ++k) {
      const double since = 1e-9 * static_cast<double>(t_ns - k * kTickNs);
      p_W += (since / kMass) * push_at(k);
    }
    return p_W;
  };
  SceneFrame scene{};
  scene.objects.push_back(test::scene_object());
  give_mass(scene, kMass);
  Counters hand(-5 * kTickNs);
  for (int64_t k = -5; k <= 12; ++k) {
    hand.push(k * kTickNs, push_at(k));
    if (k == saw) hand.seen_by(scene);
    if (k == saw) {
      test::set_time(scene, made * kTickNs);
      scene.objects[0].X_WO.p = truth(scene.t_ns, saw);
      scene.objects[0].V_WO.v = (1 / kMass) * hand.frame.pushes[0].impulse_W.f;
    }
    if (k < made || scene.seen[0].t_ns == 0) continue;
    for (const int64_t t_ns : {k * kTickNs, k * kTickNs + 400'000}) {
      CHECK_THAT(object_pose_at(scene, 0, t_ns, push_of(hand.frame, kFirstHand)).p,
                 IsNear(truth(t_ns, k), 1e-14));
    }
    CHECK_THAT(object_twist_at(scene, 0, k * kTickNs, push_of(hand.frame, kFirstHand)).v,
               IsNear((1 / kMass) * hand.frame.pushes[0].impulse_W.f, 1e-12));
  }
}

TEST_CASE("scene pose: acceleration carries an object as a throw does", "[wire][push]") {
  SceneFrame scene = one_object();
  test::add_response(scene, 0).acceleration_W = {{0, 0, -9.81}, {0, 2, 0}};
  const Counters hand(0);
  const Pose X_WO =
      object_pose_at(scene, 0, scene.t_ns + 10 * kTickNs, push_of(hand.frame, kFirstHand));
  CHECK_THAT(X_WO.p, IsNear(scene.objects[0].X_WO.p + 0.01 * scene.objects[0].V_WO.v +
                                Vec3{0, 0, -490.5e-6},
                            1e-15));
  const Twist V_WO =
      object_twist_at(scene, 0, scene.t_ns + 10 * kTickNs, push_of(hand.frame, kFirstHand));
  CHECK_THAT(V_WO.v, IsNear(scene.objects[0].V_WO.v + Vec3{0, 0, -0.0981}, 1e-15));
  CHECK_THAT(V_WO.w, IsNear(scene.objects[0].V_WO.w + Vec3{0, 0.02, 0}, 1e-15));
}

TEST_CASE("scene pose: beyond 20 ms an object stays where it was carried to", "[wire][push]") {
  SceneFrame scene = one_object();
  give_mass(scene, 0.05);
  scene.responses[0].acceleration_W.v = {0, 0, -9.81};
  Counters hand(90 * kTickNs);
  hand.seen_by(scene);
  for (int64_t k = 100; k <= 120; ++k) hand.push(k * kTickNs, {0.002, 0, 0.001});
  const Pose last = object_pose_at(scene, 0, 120 * kTickNs, push_of(hand.frame, kFirstHand));
  CHECK(norm(last.p - scene.objects[0].X_WO.p) > 1e-3);
  const int64_t later = GENERATE(121, 150, 5'000);
  // the servo goes on with ticks in which nothing is counted
  for (int64_t k = 121; k <= later; ++k) hand.push(k * kTickNs, {});
  const int64_t t_ns = later * kTickNs;
  CHECK_THAT(object_pose_at(scene, 0, t_ns, push_of(hand.frame, kFirstHand)).p,
             IsNear(last.p, 1e-12));
  CHECK(object_twist_at(scene, 0, t_ns, push_of(hand.frame, kFirstHand)) == Twist{});
}

TEST_CASE("scene pose: counters that sim has not used yet, or of another servo, move nothing",
          "[wire][push]") {
  SceneFrame scene = one_object();
  give_mass(scene, 0.05);
  Counters before(10 * kTickNs);
  before.push(20 * kTickNs, {0.3, 0.2, 0.1});
  if (GENERATE(false, true)) before.seen_by(scene);
  Counters after(99 * kTickNs);
  after.push(100 * kTickNs, {0, 0, 0.01});
  const int64_t t_ns = scene.t_ns + 2 * kTickNs;
  CHECK(object_pose_at(scene, 0, t_ns, push_of(after.frame, kFirstHand)) ==
        object_pose_at(scene, 0, t_ns));
  CHECK_FALSE(takes_pushes(scene, 0, kFirstHand, after.frame.impulses_since_ns, t_ns));
  after.seen_by(scene);
  CHECK(takes_pushes(scene, 0, kFirstHand, after.frame.impulses_since_ns, t_ns));
  CHECK_FALSE(
      takes_pushes(scene, 0, kFirstHand, after.frame.impulses_since_ns, scene.t_ns + 21 * kTickNs));
}

TEST_CASE("scene pose: an object has its own instant, and goes on for as long as its mover says",
          "[wire][push]") {
  SceneFrame scene = one_object();
  give_mass(scene, 0.05);
  SceneObject& object = scene.objects[0];
  object.t_ns = 90 * kTickNs;
  const auto [says_ns, most_ns] = GENERATE(table<int64_t, int64_t>(
      {{50 * kTickNs, 50 * kTickNs}, {0, 0}, {-1, 0}, {INT64_MAX, 100 * kTickNs}}));
  object.extrapolation_ns = says_ns;
  Counters hand(80 * kTickNs);
  hand.seen_by(scene);
  const int64_t end_ns = object.t_ns + most_ns;
  const Pose last = extrapolate(object.X_WO, object.V_WO, seconds_of(most_ns));
  CHECK_THAT(object_pose_at(scene, 0, end_ns).p, IsNear(last.p, 1e-12));
  CHECK(object_twist_at(scene, 0, end_ns) == object.V_WO);
  CHECK(takes_pushes(scene, 0, kFirstHand, hand.frame.impulses_since_ns, end_ns));
  CHECK_THAT(object_pose_at(scene, 0, end_ns + kTickNs).p, IsNear(last.p, 1e-12));
  CHECK(object_twist_at(scene, 0, end_ns + kTickNs) == Twist{});
  CHECK_FALSE(takes_pushes(scene, 0, kFirstHand, hand.frame.impulses_since_ns, end_ns + kTickNs));
}

TEST_CASE("scene pose: each hand has its own counters for each response", "[wire][push]") {
  SceneFrame scene{};
  for (uint32_t i = 0; i < 3; ++i) scene.objects.push_back(test::scene_object());
  // the second object has the first response, the third the second one
  scene.n_hands = 2;
  scene.responses.resize(2);
  scene.seen.resize(4);
  for (size_t k = 0; k < 4; ++k) scene.seen[k].t_ns = static_cast<int64_t>(k) + 1;
  scene.objects[1].response = 0, scene.objects[2].response = 1;
  CHECK(seen_of(scene, 0, 0) == nullptr);
  CHECK(seen_of(scene, 1, 0)->t_ns == 1);
  CHECK(seen_of(scene, 1, 1)->t_ns == 2);
  CHECK(seen_of(scene, 2, 1)->t_ns == 4);
  CHECK(seen_of(scene, 2, 2) == nullptr);
}

TEST_CASE("scene pose: a push beside the centre of mass turns the object", "[wire][push]") {
  SceneFrame scene{};
  scene.objects.push_back(test::scene_object());
  // a rod on a hinge 0.5 m from its end, about z: mobility 4 j jᵀ with j = (0.5, 0, 0, 0, 0, 1)
  auto& mobility = test::add_response(scene, 0).mobility;
  mobility[0] = 1;
  mobility[5] = mobility[6 * 5] = 2;
  mobility[6 * 5 + 5] = 4;
  scene.seen[0].t_ns = 1;
  Counters hand(1);
  hand.push(1, {0.5, 0, 0});
  hand.push(1 + kTickNs, {});
  const Pose X_WO = object_pose_at(scene, 0, 1 + kTickNs, push_of(hand.frame, kFirstHand));
  CHECK_THAT(to_rotation_vector(X_WO.q), IsNear({0, 0, 2 * 0.5 * kTick}, 1e-15));
  CHECK_THAT(X_WO.p, IsNear({0.5 * kTick, 0, 0}, 1e-15));
}
