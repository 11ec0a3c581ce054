// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/scene.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"
#include "sim/step.h"
#include "tests/support/frames.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::scene_object;
using haptic::test::tol;

namespace {

// a central difference over h errs by h²/6 of the third derivative: 1e-8·(2π)³ of the amplitude
constexpr int64_t kHalfStep_ns = 100'000;
constexpr double kDifferenceError = 1e-5;

ObjectConfig moving_object(MotionKind kind, double amplitude, double frequency) {
  ObjectConfig object;
  object.X_WO.p = {0.1, -0.2, 0.3};
  object.X_WO.q = from_rotation_vector({0.4, -0.9, 1.3});
  object.motion.kind = kind;
  object.motion.axis_O = {1, -2, 0.5};
  object.motion.amplitude = amplitude;
  object.motion.frequency = frequency;
  return object;
}

SimModel three_objects() {
  SessionConfig config;
  config.n_objects = 3;
  config.objects[0] = moving_object(MotionKind::kOscillate, 0.02, 0.7);
  config.objects[1] = moving_object(MotionKind::kSpin, 0, 0.3);
  config.objects[2] = moving_object(MotionKind::kStatic, 0.02, 0.7);
  return build_sim(config);
}

Vec3 rotation_between(const Quat& a, const Quat& b) {
  return to_rotation_vector(b * conjugate(a));
}

}  // namespace

TEST_CASE("scene: the first frame shows the configured poses", "[sim]") {
  const SimModel model = three_objects();
  SimState state;
  const SceneFrame frame = sim_step(model, state, 123'456'789'000);
  CHECK(frame.seq == 1);
  CHECK(frame.objects.size() == 3);
  for (uint32_t i = 0; i < 3; ++i) {
    CHECK_THAT(frame.objects[i].X_WO.p, IsNear(model.objects[i].X_WO.p, kAlgebra));
    CHECK_THAT(rotation_between(frame.objects[i].X_WO.q, model.objects[i].X_WO.q),
               IsNear({}, kAlgebra));
  }
}

TEST_CASE("scene: a quarter period is the amplitude along the axis and a quarter turn", "[sim]") {
  ObjectConfig object = moving_object(MotionKind::kOscillate, 0.02, 1);
  const Vec3 axis_W = rotate(object.X_WO.q, normalized(object.motion.axis_O));
  CHECK_THAT(scripted_state(object, kPi / 2, 2 * kPi).X_WO.p,
             IsNear(object.X_WO.p + 0.02 * axis_W, kAlgebra));
  object.motion.kind = MotionKind::kSpin;
  const Pose X_WO = scripted_state(object, kPi / 2, 2 * kPi).X_WO;
  CHECK_THAT(rotation_between(object.X_WO.q, X_WO.q), IsNear(kPi / 2 * axis_W, kAlgebra));
  CHECK(X_WO.p == object.X_WO.p);
}

TEST_CASE("scene: twists are the finite differences of the poses at every time scale", "[sim]") {
  const SimModel model = three_objects();
  const double scale = GENERATE(1.0, 0.25, 3.0, 0.0);
  const int64_t start_ns = GENERATE(take(5, random(int64_t{1}, int64_t{30'000'000'000})));
  CAPTURE(scale, start_ns);
  SimState state;
  sim_step(model, state, 0, scale);
  const SceneFrame before = sim_step(model, state, start_ns - kHalfStep_ns, scale);
  const SceneFrame at = sim_step(model, state, start_ns, scale);
  const SceneFrame after = sim_step(model, state, start_ns + kHalfStep_ns, scale);
  const double dt = 2e-9 * kHalfStep_ns;
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    CAPTURE(i);
    CHECK_THAT(at.objects[i].V_WO.v,
               IsNear((after.objects[i].X_WO.p - before.objects[i].X_WO.p) / dt, kDifferenceError));
    CHECK_THAT(at.objects[i].V_WO.w,
               IsNear(rotation_between(before.objects[i].X_WO.q, after.objects[i].X_WO.q) / dt,
                      kDifferenceError));
  }
}

TEST_CASE("scene: a spin stays normalised and in phase over a day", "[sim]") {
  const SimModel model = three_objects();
  SimState state;
  const int64_t hour_ns = 3'600'000'000'000;
  for (int64_t t_ns = 0; t_ns <= 24 * hour_ns; t_ns += hour_ns / 97) {
    const Quat q = sim_step(model, state, t_ns).objects[1].X_WO.q;
    REQUIRE(std::fabs(dot(q, q) - 1) <= tol(kAlgebra));
  }
  // 0.3 turns per second: a day is a whole number of turns; 1.6e5 rad leave 3e-11 of a radian
  const SceneFrame last = sim_step(model, state, 24 * hour_ns);
  CHECK_THAT(rotation_between(last.objects[1].X_WO.q, model.objects[1].X_WO.q), IsNear({}, 1e-9));
}

TEST_CASE("scene: a restarted sim continues where the last frame's extrapolation ended", "[sim]") {
  const SimModel model = three_objects();
  const int64_t died_ns = GENERATE(take(20, random(int64_t{1}, int64_t{20'000'000'000})));
  const int64_t outage_ns = GENERATE(int64_t{0}, int64_t{8'000'000}, int64_t{5'000'000'000});
  CAPTURE(died_ns, outage_ns);
  SimState first;
  sim_step(model, first, 0);
  const SceneFrame last = sim_step(model, first, died_ns);

  SimState second;
  resume(model, second, last);
  const SceneFrame next = sim_step(model, second, died_ns + outage_ns);
  CHECK(next.seq == last.seq + 1);
  CHECK(next.t_ns == died_ns + outage_ns);
  // the uninterrupted sim at the instant where readers stopped extrapolating
  const int64_t shown_ns = died_ns + std::min(outage_ns, kExtrapolationNs);
  const SceneFrame expected = sim_step(model, first, shown_ns);
  // near the turning point of an oscillation asin gives the phase to √ε, the position to ε
  constexpr double kPhaseError = 1e-7;
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    CAPTURE(i);
    CHECK_THAT(next.objects[i].X_WO.p, IsNear(expected.objects[i].X_WO.p, kPhaseError * 0.02));
    CHECK_THAT(next.objects[i].V_WO.v, IsNear(expected.objects[i].V_WO.v, kPhaseError));
    CHECK_THAT(rotation_between(next.objects[i].X_WO.q, expected.objects[i].X_WO.q),
               IsNear({}, kPhaseError));
    CHECK_THAT(next.objects[i].V_WO.w, IsNear(expected.objects[i].V_WO.w, kAlgebra));
  }
}

TEST_CASE("scene: a resumed scene does not jump even when it was paused at a turning point",
          "[sim]") {
  const SimModel model = three_objects();
  const double phase = GENERATE(-1.5707, 0.3, 1.5707963, 2.8);
  SceneFrame last{};
  last.n_hands = 1;
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    // time scale 0: no twist
    last.objects.push_back(scene_object(scripted_state(model.objects[i], phase, 0).X_WO));
  }
  SimState state;
  resume(model, state, last);
  const SceneFrame next = sim_step(model, state, last.t_ns);
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    CHECK_THAT(next.objects[i].X_WO.p, IsNear(last.objects[i].X_WO.p, kAlgebra));
    CHECK_THAT(rotation_between(next.objects[i].X_WO.q, last.objects[i].X_WO.q),
               IsNear({}, kAlgebra));
  }
}

TEST_CASE("scene: after a frame of another scene it begins anew, and counts on", "[sim]") {
  const SimModel model = three_objects();
  SimState first;
  sim_step(model, first, 0);
  SceneFrame last = sim_step(model, first, 400'000'000);
  SECTION("an object too few") {
    last.objects.resize(2);
  }
  SECTION("a body too many") {
    test::add_response(last, 0);
  }
  SECTION("a joint too many") {
    last.joints.push_back({});
  }
  SECTION("no hand") {
    last.n_hands = 0;
  }
  SimState second;
  resume(model, second, last);
  const SceneFrame next = sim_step(model, second, 500'000'000);
  CHECK(next.seq == last.seq + 1);
  REQUIRE(next.objects.size() == 3);
  CHECK_THAT(next.objects[0].X_WO.p, IsNear(model.objects[0].X_WO.p, kAlgebra));
}

TEST_CASE("scene: a clock that goes back holds the scene", "[sim]") {
  const SimModel model = three_objects();
  SimState state;
  sim_step(model, state, 0);
  const SceneFrame late = sim_step(model, state, 400'000'000);
  const SceneFrame early = sim_step(model, state, 300'000'000);
  CHECK(early.t_ns == late.t_ns);
  CHECK(early.objects[0].t_ns == late.t_ns);
  CHECK(early.objects[0].X_WO == late.objects[0].X_WO);
}
