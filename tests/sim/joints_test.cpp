// SPDX-License-Identifier: GPL-3.0-or-later
// Hinges and sliders with what acts along their coordinate, against closed forms.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"
#include "tests/sim/joint_scene.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Position under a constant load from rest, by mass (or inertia), damping and stiffness.
double closed_form(double load, double m, double c, double k, double t) {
  if (k > 0) {
    const double a = c / (2 * m), w = std::sqrt(k / m - a * a);
    return load / k * (1 - std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t)));
  }
  if (c > 0) return load / c * (t - m / c * (1 - std::exp(-c * t / m)));
  return 0.5 * load / m * t * t;
}

/// A table of `amplitude` · sin(n q) over one turn.
void set_sine(JointConfig& joint, double amplitude, int n, double half_range) {
  joint.n_detents = kMostDetents;
  for (uint32_t i = 0; i < kMostDetents; ++i) {
    const double q = half_range * (2.0 * i / (kMostDetents - 1) - 1);
    joint.detents[i] = {q, amplitude * std::sin(n * q)};
  }
}

}  // namespace

TEST_CASE("joints: a hinge under a constant push is where the closed form puts it",
          "[sim][joints]") {
  const auto [damping, stiffness] =
      GENERATE(std::pair(0.0, 0.0), std::pair(5e-3, 0.0), std::pair(2e-3, 0.5));
  constexpr double kTorque = 0.02;  // [N·m]
  CAPTURE(damping, stiffness);
  RodScene scene(JointKind::kHinge);
  scene.joint.damping = damping;
  scene.joint.stiffness = stiffness;
  BodySim sim(scene);
  PushingFrame hand(sim);
  // half of the push is a force at the middle, across the rod, and what pulls along it does nothing
  double largest = 0, error = 0;
  for (int k = 1; k <= 400; ++k) {
    const double q = sim.frame.joints[0].position;
    const Vec3 along{std::cos(q), std::sin(q), 0}, across{-std::sin(q), std::cos(q), 0};
    const Vec3 force = kTorque / RodScene::kLength * across + 1.0 * along + Vec3{0, 0, 0.5};
    sim.step(hand.push({force, {0.01, -0.02, kTorque / 2}}));
    const double exact = closed_form(kTorque, RodScene::kInertia, damping, stiffness, kTick * k);
    largest = std::max(largest, exact);
    error = std::max(error, std::fabs(sim.frame.joints[0].position - exact));
  }
  CAPTURE(error, largest);
  CHECK(error <= 0.01 * largest);
  // where the coordinate says, exactly
  const Pose X = turned_rod(sim.frame.joints[0].position);
  CHECK_THAT(sim.frame.objects[0].X_WO.p, IsNear(X.p, 1e-6));
  CHECK(std::fabs(dot(sim.frame.objects[0].X_WO.q, X.q)) == Approx(1).margin(1e-9));
}

TEST_CASE("joints: a slider under a constant push and its weight", "[sim][joints]") {
  const auto [damping, stiffness] =
      GENERATE(std::pair(0.0, 0.0), std::pair(2.0, 0.0), std::pair(1.0, 50.0));
  CAPTURE(damping, stiffness);
  RodScene scene(JointKind::kSlider);
  scene.joint.axis_W = {0.6, 0, 0.8};
  scene.joint.at_W = {0, 0.03, 0};
  scene.joint.damping = damping;
  scene.joint.stiffness = stiffness;
  scene.config.gravity_W = {0, 0, -9.81};
  BodySim sim(scene);
  PushingFrame hand(sim);
  const double load = 3 * 0.6 - RodScene::kMass * 9.81 * 0.8;
  double largest = 0, error = 0;
  for (int k = 1; k <= 300; ++k) {
    sim.step(hand.push({{3, 0.5, 0}, {0.01, 0.02, -0.03}}));
    const double exact = closed_form(load, RodScene::kMass, damping, stiffness, kTick * k);
    largest = std::max(largest, std::fabs(exact));
    error = std::max(error, std::fabs(sim.frame.joints[0].position - exact));
  }
  CAPTURE(error, largest);
  CHECK(error <= 0.01 * largest);
  CHECK_THAT(
      sim.frame.objects[0].X_WO.p,
      IsNear(scene.config.objects[0].X_WO.p + sim.frame.joints[0].position * scene.joint.axis_W,
             1e-9));
}

TEST_CASE("joints: the torque along a hinge is the table's", "[sim][joints]") {
  constexpr double kTop = 0.3;  // [N·m]
  RodScene scene(JointKind::kHinge);
  set_sine(scene.joint, kTop, 4, 1.5);
  BodySim sim(scene);
  double error = 0;
  for (double q = -1.4; q <= 1.4; q += 0.05) {
    begin_at(sim, turned_rod(q), {}, q);
    sim.step();
    const double torque = RodScene::kInertia * sim.frame.joints[0].velocity / kTick;
    error = std::max(error, std::fabs(torque - kTop * std::sin(4 * q)));
    // what readers extrapolate by
    const double alpha = sim.frame.responses[0].acceleration_W.w.z;
    const double now = kTop * std::sin(4 * sim.frame.joints[0].position);
    error = std::max(error, std::fabs(RodScene::kInertia * alpha - now));
  }
  CAPTURE(error);
  CHECK(error <= 0.01 * kTop);
}

TEST_CASE("joints: a cycle over a detent returns what the table integrates to", "[sim][joints]") {
  constexpr double kTop = 0.1, kLead = 20.0, kCalm = 0.2;  // [N·m], [N·m/rad], [N·m·s/rad]
  constexpr int kHalf = 700;                               // ticks of the way there
  RodScene scene(JointKind::kHinge);
  set_sine(scene.joint, -kTop, 4, 1.0);  // a valley at 0, tops at ± π/4
  BodySim sim(scene);
  PushingFrame hand(sim);
  double there = 0, whole = 0;
  for (int k = 0; k < 2 * kHalf; ++k) {
    const double s = 0.5 - 0.5 * std::cos(kPi * k / kHalf);
    const JointState& q = sim.frame.joints[0];
    const double before = q.position;
    const double torque = kLead * (kPi / 4 * s - q.position) - kCalm * q.velocity;
    sim.step(hand.push({{}, {0, 0, torque}}));
    whole += torque * (sim.frame.joints[0].position - before);
    if (k + 1 == kHalf) there = whole;
  }
  // ∫ kTop sin 4q dq from 0 to π/4; the lead lags by 2 % of a degree, where the table is flat
  const double exact = kTop / 2;
  CAPTURE(there, whole, exact);
  CHECK(there == Approx(exact).epsilon(0.01));
  // what the hand's own damper has taken in the cycle is less than the detent by far
  CHECK(std::fabs(whole) <= 0.01 * exact);
}

TEST_CASE("joints: a spring too stiff for the step gains no energy", "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  scene.joint.stiffness = 1e6 * RodScene::kInertia * GENERATE(0.25, 100.0);  // ω dt = 0.5, 10
  BodySim sim(scene);
  begin_at(sim, turned_rod(0.1), {}, 0.1);
  const double start = 0.5 * scene.joint.stiffness * 0.1 * 0.1;
  for (int k = 0; k < 2000; ++k) {
    const JointState& q = sim.step().joints[0];
    const double energy = 0.5 * scene.joint.stiffness * q.position * q.position +
                          0.5 * RodScene::kInertia * q.velocity * q.velocity;
    REQUIRE(energy <= 1.001 * start + 10e-6);
  }
}

TEST_CASE("joints: a hinge coasts at its speed, and stays on its axis", "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  BodySim sim(scene);
  constexpr double kSpeed = 12;  // [rad/s]
  begin_at(sim, turned_rod(0), {{0, kSpeed * RodScene::kLength / 2, 0}, {0, 0, kSpeed}}, 0);
  const double start = sim.frame.joints[0].position;
  for (int k = 1; k <= 2000; ++k) {
    sim.step();
    REQUIRE(sim.frame.joints[0].velocity == Approx(kSpeed).epsilon(1e-9));
    REQUIRE(sim.frame.joints[0].position == Approx(start + kSpeed * kTick * k).epsilon(1e-9));
    REQUIRE(std::fabs(norm(sim.frame.objects[0].X_WO.p) - RodScene::kLength / 2) < 1e-9);
    // what it accelerates by is towards the axis
    const Vec3 a = sim.frame.responses[0].acceleration_W.v;
    REQUIRE_THAT(a, IsNear(-kSpeed * kSpeed * sim.frame.objects[0].X_WO.p, 1e-3));
  }
}

TEST_CASE("joints: the mobility of a hinged body has rank one", "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  BodySim sim(scene);
  begin_at(sim, turned_rod(0.4), {}, 0.4);
  const auto& mobility = sim.step().responses[0].mobility;
  const double r = RodScene::kLength / 2, q = 0.4;
  const std::array<double, 6> h{-r * std::sin(q), r * std::cos(q), 0, 0, 0, 1};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) {
      CAPTURE(i, j);
      CHECK(mobility[6 * i + j] ==
            Approx(h[i] * h[j] / RodScene::kInertia).margin(1e-4 / RodScene::kInertia));
    }
  }
}

TEST_CASE("joints: an end stop holds, and lets go", "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  scene.joint.upper = 0.05;
  BodySim sim(scene);
  PushingFrame hand(sim);
  for (int k = 0; k < 300; ++k) sim.step(hand.push({{}, {0, 0, 0.1}}));
  CHECK(sim.frame.joints[0].position == Approx(0.05).margin(1e-9));
  CHECK(sim.frame.joints[0].velocity == Approx(0).margin(1e-12));
  const auto& mobility = sim.frame.responses[0].mobility;
  CHECK(*std::max_element(mobility.begin(), mobility.end()) < 1e-4 / RodScene::kInertia);
  for (int k = 0; k < 100; ++k) sim.step(hand.push({{}, {0, 0, -0.1}}));
  CHECK(sim.frame.joints[0].position ==
        Approx(0.05 - closed_form(0.1, RodScene::kInertia, 0, 0, 0.1)).epsilon(0.01));
}

TEST_CASE("joints: dry friction holds up to its torque and takes it beyond", "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  scene.joint.friction = 0.02;
  BodySim sim(scene);
  PushingFrame hand(sim);
  for (int k = 0; k < 200; ++k) sim.step(hand.push({{}, {0, 0, 0.018}}));
  CHECK(std::fabs(sim.frame.joints[0].position) < 1e-9);
  const auto& mobility = sim.frame.responses[0].mobility;
  CHECK(*std::max_element(mobility.begin(), mobility.end()) < 1e-4 / RodScene::kInertia);
  const double start = sim.frame.joints[0].position;
  for (int k = 0; k < 200; ++k) sim.step(hand.push({{}, {0, 0, 0.03}}));
  CHECK(sim.frame.joints[0].position - start ==
        Approx(closed_form(0.01, RodScene::kInertia, 0, 0, 0.2)).epsilon(0.01));
}

TEST_CASE("joints: a restarted sim has the joints of its last frame, whole turns too",
          "[sim][joints]") {
  RodScene scene(JointKind::kHinge);
  set_sine(scene.joint, 0.01, 1, 0.5);
  BodySim sim(scene);
  PushingFrame hand(sim);
  for (int k = 0; k < 500; ++k) sim.step(hand.push({{}, {0, 0, 0.05}}));
  REQUIRE(sim.frame.joints[0].position > 2.5 * kPi);
  const SceneFrame last = sim.frame;
  const int64_t outage_ns = GENERATE(0, 2, 15, 500) * int64_t{1'000'000};
  SimState second;
  resume(sim.model, second, last);
  const SceneFrame next = sim_step(sim.model, second, {&hand.frame}, last.t_ns + outage_ns);
  // readers have carried it on for as long, at most 20 ms, by its acceleration too
  const double t = std::min(1e-9 * static_cast<double>(outage_ns), seconds_of(kExtrapolationNs));
  const double alpha = last.responses[0].acceleration_W.w.z;
  const double expected = last.joints[0].position + last.joints[0].velocity * t + alpha * t * t / 2;
  CHECK(next.joints.size() == 1);
  CHECK(next.joints[0].position == Approx(expected).epsilon(1e-6));
  CHECK(next.joints[0].velocity == Approx(last.joints[0].velocity).epsilon(0.02));
}
