// SPDX-License-Identifier: GPL-3.0-or-later
// Balls, cylinders, fixed joints, curves, and joints between two bodies.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "proto/math/units.h"
#include "sim/joint/curve.h"
#include "sim/joint/spline.h"
#include "tests/sim/joint_scene.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("joints: a ball lets a rod swing as a physical pendulum", "[sim][joints]") {
  RodScene scene(JointKind::kBall);
  scene.config.gravity_W = {0, 0, -kGravity};
  // hanging, a little aside in both directions
  const double r = RodScene::kLength / 2, aside = 0.05;
  const Quat down = from_rotation_vector({0, kPi / 2, 0});
  const Quat turn = from_rotation_vector({aside, 0, 0}) * down;
  scene.config.objects[0].X_WO = {rotate(turn, {r, 0, 0}), turn};
  BodySim sim(scene);
  const double w = std::sqrt(RodScene::kMass * kGravity * r / RodScene::kInertia);
  const int half = static_cast<int>(std::lround(kPi / w / kTick));
  double loose = 0;
  for (int k = 0; k < 4 * half; ++k) {
    sim.step();
    const Vec3 end = sim.frame.objects[0].X_WO * Vec3{-r, 0, 0};
    loose = std::max(loose, norm(end));
  }
  // two periods later it is where it was
  CHECK_THAT(sim.frame.objects[0].X_WO.p, IsNear(scene.config.objects[0].X_WO.p, 0.1 * r * aside));
  CAPTURE(loose);
  CHECK(loose < 20e-6);
}

TEST_CASE("joints: a cylinder falls along its axis and turns about it", "[sim][joints]") {
  RodScene scene(JointKind::kCylinder);
  scene.config.gravity_W = {0.5, -0.2, -kGravity};
  scene.joint.axis_W = {0, 0, 1};
  BodySim sim(scene);
  PushingFrame hand(sim);
  for (int k = 0; k < 100; ++k) sim.step(hand.push({{}, {0.01, 0.02, 0.005}}));
  CHECK(sim.frame.joints[0].position == Approx(-0.5 * kGravity * 0.01).epsilon(0.02));
  CHECK(sim.frame.joints[0].velocity == Approx(-kGravity * 0.1).epsilon(1e-3));
  // about the axis, by the hand and by gravity across it
  CHECK(sim.frame.objects[0].V_WO.w.z != Approx(0).margin(0.01));
  CHECK_THAT(rotate(sim.frame.objects[0].X_WO.q, {0, 0, 1}), IsNear({0, 0, 1}, 1e-4));
}

TEST_CASE("joints: two bodies fixed to each other are one", "[sim][joints]") {
  RodScene scene(JointKind::kFixed);
  scene.add_box({0.02, 0.02, 0.02}, {{0.11, 0, 0}, {}}, 0.1);
  scene.joint.to = 1;
  scene.joint.at_W = {0.1, 0, 0};
  BodySim sim(scene);
  PushingFrame hand(sim);
  const Vec3 force{0.3, 0.5, -0.2};
  for (int k = 0; k < 100; ++k) sim.step(hand.push({force, {}}));
  const Vec3 momentum =
      RodScene::kMass * sim.frame.objects[0].V_WO.v + 0.1 * sim.frame.objects[1].V_WO.v;
  CHECK_THAT(momentum, IsNear(0.1 * force, 1e-9));
  const Pose between = inverse(sim.frame.objects[0].X_WO) * sim.frame.objects[1].X_WO;
  CHECK_THAT(between.p, IsNear({0.06, 0, 0}, 50e-6));
  CHECK(norm(to_rotation_vector(between.q)) < 2e-3);
}

TEST_CASE("joints: two free bodies on a spring oscillate about what they weigh together",
          "[sim][joints]") {
  RodScene scene(JointKind::kSlider);
  scene.add_box({0.02, 0.02, 0.02}, {{0.16, 0, 0}, {}}, 0.1);
  scene.joint.to = 1;
  scene.joint.axis_W = {1, 0, 0};
  scene.joint.stiffness = 80;
  scene.joint.rest = 0.01;
  BodySim sim(scene);
  const double reduced = RodScene::kMass * 0.1 / (RodScene::kMass + 0.1);
  const double w = std::sqrt(scene.joint.stiffness / reduced);
  double error = 0;
  for (int k = 1; k <= 300; ++k) {
    sim.step();
    error = std::max(
        error, std::fabs(sim.frame.joints[0].position - 0.01 * (1 - std::cos(w * kTick * k))));
    REQUIRE_THAT(RodScene::kMass * sim.frame.objects[0].V_WO.v + 0.1 * sim.frame.objects[1].V_WO.v,
                 IsNear({}, 1e-9));
  }
  CAPTURE(error);
  CHECK(error <= 0.03 * 0.02);
}

TEST_CASE("joints: a bead on a curve has the speed of its height", "[sim][joints]") {
  RodScene scene(JointKind::kCurve);
  constexpr double kRadius = 0.1;
  // a quarter of a circle down from where the rod is
  const Vec3 start = scene.config.objects[0].X_WO.p;
  scene.joint.at_W = start;
  scene.joint.n_points = 8;
  for (uint32_t i = 0; i < 8; ++i) {
    const double a = kPi / 2 * (i + 1) / 8;
    scene.joint.points_W[i] = start + kRadius * Vec3{1 - std::cos(a), 0, -std::sin(a)};
  }
  scene.config.gravity_W = {0, 0, -kGravity};
  BodySim sim(scene);
  while (sim.frame.joints[0].position < 0.9 * kRadius * kPi / 2) {
    sim.step();
    const Vec3 at = sim.frame.objects[0].X_WO.p - start;
    // the natural spline is flatter at its ends
    REQUIRE(std::hypot(at.x - kRadius, at.z) == Approx(kRadius).epsilon(3e-3));
    REQUIRE(sim.frame.joints[0].velocity ==
            Approx(std::sqrt(-2 * kGravity * at.z)).epsilon(0.01).margin(0.02));
    REQUIRE(sim.frame.objects[0].V_WO.w == Vec3{});
  }
  for (int k = 0; k < 100; ++k) sim.step();
  CHECK_THAT(sim.frame.objects[0].X_WO.p, IsNear(start + kRadius * Vec3{1, 0, -1}, 1e-6));
  CHECK(sim.frame.joints[0].velocity == Approx(0).margin(1e-9));
}

TEST_CASE("spline: natural, through its points, smooth, and near the sine they are of",
          "[sim][joints]") {
  std::vector<double> x, y;
  for (int i = 0; i <= 16; ++i) {
    x.push_back(kPi * i / 16 + (i % 2 == 0 ? 0.0 : 0.03));
    y.push_back(std::sin(x.back()));
  }
  const Spline spline = build_spline(x, y);
  constexpr double kNear = 1e-7;
  for (size_t i = 0; i < x.size(); ++i) {
    const SplineValue at = spline_at(spline, x[i]);
    CHECK(at.y == Approx(y[i]).margin(1e-12));
    if (i == 0 || i + 1 == x.size()) {
      CHECK(at.second == Approx(0).margin(1e-12));
      continue;
    }
    const SplineValue left = spline_at(spline, x[i] - kNear),
                      right = spline_at(spline, x[i] + kNear);
    CHECK(left.first == Approx(right.first).margin(10 * kNear));
    CHECK(left.second == Approx(right.second).margin(100 * kNear));
    CHECK((right.y - left.y) / (2 * kNear) == Approx(at.first).margin(1e-6));
  }
  for (double t = 0; t <= kPi; t += 0.01) {
    CHECK(spline_at(spline, t).y == Approx(std::sin(t)).margin(5e-4));
  }
}

TEST_CASE("curve: its length is that of the way", "[sim][joints]") {
  std::vector<Vec3> points;
  for (int i = 0; i <= 12; ++i) {
    const double a = kPi * i / 12;
    points.push_back({0.1 * std::cos(a), 0.1 * std::sin(a), 0.05 * a});
  }
  const Curve curve = build_curve(points);
  const double exact = kPi * std::hypot(0.1, 0.05);
  CHECK(curve.length == Approx(exact).epsilon(2e-3));
  const double middle = curve.length / 2, step = 1e-5;
  const Vec3 d = curve_at(curve, middle + step).p - curve_at(curve, middle - step).p;
  CHECK(norm(d) == Approx(2 * step).epsilon(1e-4));
  CHECK_THAT(curve_at(curve, middle).tangent, IsNear(normalized(d), 1e-6));
  CHECK(nearest_length(curve, curve_at(curve, 0.2).p + Vec3{0, 0, 1e-3}, 0.195) ==
        Approx(0.2).margin(1e-3));
  // beyond its end it goes on straight
  const CurvePoint end = curve_at(curve, curve.length);
  CHECK_THAT(curve_at(curve, curve.length + 0.01).p, IsNear(end.p + 0.01 * end.tangent, 1e-12));
}
