// SPDX-License-Identifier: GPL-3.0-or-later
// Energy by poses and twists alone: what swings, falls, bounces and rolls gains none. A hundred
// scenes at random, ten minutes of each: HAPTIC_TORTURE_SCALE=200 (docs/pushed-bodies.md).
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"
#include "tests/sim/energy_judge.h"
#include "tests/sim/joint_scene.h"
#include "tests/support/meshes.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Length of a run [s].
double seconds() {
  return std::min(3 * torture_scale(), 600.0);
}

/// The coordinate of a hinge or slider by the poses of two bodies; the judge's own way to it.
class PoseCoordinate {
 public:
  PoseCoordinate(const JointConfig& joint, const SceneFrame& start) : joint_(joint) {
    X_start_ = between(start);
    axis_B_ = rotate(conjugate(pose(start, joint.to).q), joint.axis_W);
    at_A_ = inverse(pose(start, joint.object)) * joint.at_W;
  }
  double at(const SceneFrame& frame) {
    const Pose X = between(frame);
    if (joint_.kind != JointKind::kHinge) {
      return dot(axis_B_, X * at_A_ - X_start_ * at_A_);
    }
    const Quat turned = X.q * conjugate(X_start_.q);
    const double half = std::atan2(dot(Vec3{turned.x, turned.y, turned.z}, axis_B_), turned.w);
    last_ =
        2 * half + 2 * std::numbers::pi * std::round((last_ - 2 * half) / (2 * std::numbers::pi));
    return last_;
  }

 private:
  static Pose pose(const SceneFrame& frame, uint32_t object) {
    return object == kToWorld ? Pose{} : frame.objects[object].X_WO;
  }
  Pose between(const SceneFrame& frame) const {
    return inverse(pose(frame, joint_.to)) * pose(frame, joint_.object);
  }
  JointConfig joint_;
  Pose X_start_;
  Vec3 axis_B_, at_A_;
  double last_ = 0;
};

/// What the spring of a joint stores [J], by poses.
std::function<double(const SceneFrame&)> spring_of(const JointConfig& joint,
                                                   const SceneFrame& start) {
  auto coordinate = std::make_shared<PoseCoordinate>(joint, start);
  return [=](const SceneFrame& frame) {
    const double stretch = coordinate->at(frame) - joint.rest;
    return 0.5 * joint.stiffness * stretch * stretch;
  };
}

/// Sides of a cosine's valley and the hills beside it, as a table.
void set_hills(JointConfig& joint, double height, double length) {
  joint.n_detents = kMostDetents;
  for (uint32_t i = 0; i < kMostDetents; ++i) {
    const double q = length * (3.0 * i / (kMostDetents - 1) - 1.5);
    const double k = 2 * kPi / length;
    joint.detents[i] = {q, -height * k / 2 * std::sin(k * q)};
  }
}

struct Verdict {
  double excess, swing, largest_kinetic, last_mean, start;
};

Verdict run(BodySim& sim, EnergyJudge& judge, double seconds) {
  judge.begin(sim.frame);
  const long n = std::lround(seconds * 1e9 / static_cast<double>(sim.period_ns));
  for (long k = 0; k < n; ++k) judge.add(sim.step());
  return {judge.excess(), judge.swing(), judge.largest_kinetic(), judge.last_mean(), judge.start()};
}

/// A rod whose middle hangs `lever` from a hinge about y, let go at an angle from hanging.
BodyScene pendulum(double lever, double angle, double rate) {
  BodyScene scene;
  scene.config.sim_rate = rate;
  scene.config.gravity_W = {0, 0, -kGravity};
  const Vec3 p = lever * Vec3{std::sin(angle), 0, -std::cos(angle)};
  scene.add_box({0.01, 0.01, 2 * lever}, {p, from_rotation_vector({0, -angle, 0})}, 0.05);
  scene.config.n_joints = 1;
  JointConfig& joint = scene.config.joints[0];
  joint.kind = JointKind::kHinge;
  joint.axis_W = {0, 1, 0};
  return scene;
}

}  // namespace

TEST_CASE("energy: a free pendulum neither gains nor loses, and keeps its time", "[sim][energy]") {
  const double lever = GENERATE(0.02, 0.1), angle = GENERATE(0.2, 1.5, 3.0);
  const double rate = GENERATE(200.0, 1000.0);
  CAPTURE(lever, angle, rate);
  BodySim sim(pendulum(lever, angle, rate));
  EnergyJudge judge({judged_box(0, {0.01, 0.01, 2 * lever}, 0.05)}, {0, 0, -kGravity}, rate);
  const Verdict verdict = run(sim, judge, 6 * seconds());
  // ω² = m g r / I about the hinge
  const double inertia = 0.05 / 12 * (1e-4 + 4 * lever * lever) + 0.05 * lever * lever;
  const double w_dt = std::sqrt(0.05 * kGravity * lever / inertia) / rate;
  CAPTURE(verdict.excess, verdict.swing, verdict.largest_kinetic, w_dt);
  CHECK(verdict.excess <= 0);
  CHECK(verdict.swing <= 1.2 * w_dt * w_dt / 8 * verdict.largest_kinetic);
  CHECK(verdict.last_mean == Approx(verdict.start).margin(1e-3 * verdict.largest_kinetic));
}

namespace {

/// A brick that hangs from a ball at its corner.
struct SpinningBrick {
  static constexpr double kMass = 0.05;  // [kg]
  Vec3 edges;                            // [m]
  Twist V_WO;                            // at the start
  BodyScene scene;

  SpinningBrick(const Vec3& sides, const Vec3& spin, double rate) : edges(sides) {
    scene.config.sim_rate = rate;
    scene.config.gravity_W = {0, 0, -kGravity};
    const Vec3 arm = 0.5 * edges;  // from the ball to the middle
    scene.add_box(edges, {arm, {}}, kMass);
    scene.config.n_joints = 1;
    scene.config.joints[0].kind = JointKind::kBall;
    V_WO = {cross(spin, arm), spin};
  }
};

/// Its orientation after t seconds, by Runge and Kutta's rule on Euler's equations of motion about
/// the ball, in its own axes.
Quat spun(const SpinningBrick& brick, double t) {
  const Vec3 e = brick.edges, arm = 0.5 * e;
  constexpr double m = SpinningBrick::kMass;
  Eigen::Matrix3d inertia;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      inertia(i, k) = -m * arm[i] * arm[k];
      if (i == k) inertia(i, i) += m / 12 * (dot(e, e) - e[i] * e[i]) + m * dot(arm, arm);
    }
  }
  const Eigen::Matrix3d inverse = inertia.inverse();
  const auto vector = [](const Vec3& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
  struct State {
    Eigen::Quaterniond q;
    Eigen::Vector3d w;
  };
  const auto rate = [&](const State& s) {
    const Eigen::Vector3d down = s.q.conjugate() * Eigen::Vector3d(0, 0, -kGravity);
    const Eigen::Vector3d torque = m * vector(arm).cross(down) - s.w.cross(inertia * s.w);
    const Eigen::Quaterniond turning(0, s.w.x(), s.w.y(), s.w.z());
    Eigen::Quaterniond dq = s.q * turning;
    dq.coeffs() *= 0.5;
    return State{dq, inverse * torque};
  };
  const auto moved = [](const State& s, const State& by, double h) {
    State out = s;
    out.q.coeffs() += h * by.q.coeffs();
    out.w += h * by.w;
    return out;
  };
  State s{Eigen::Quaterniond::Identity(), vector(brick.V_WO.w)};
  const double h = 20e-6;
  for (long k = 0; k < std::lround(t / h); ++k) {
    const State a = rate(s), b = rate(moved(s, a, h / 2)), c = rate(moved(s, b, h / 2)),
                d = rate(moved(s, c, h));
    s.q.coeffs() += h / 6 * (a.q.coeffs() + 2 * b.q.coeffs() + 2 * c.q.coeffs() + d.q.coeffs());
    s.w += h / 6 * (a.w + 2 * b.w + 2 * c.w + d.w);
    s.q.normalize();
  }
  return {s.q.x(), s.q.y(), s.q.z(), s.q.w()};
}

/// A sim that goes on from its first frame with these twists.
void begin_with_twists(BodySim& sim, const std::vector<Twist>& V_WO) {
  SceneFrame last = sim.frame;
  for (size_t i = 0; i < V_WO.size(); ++i) last.objects[i].V_WO = V_WO[i];
  sim.state = {};
  resume(sim.model, sim.state, last);
  sim.frame = sim_step(sim.model, sim.state, last.t_ns);
}

}  // namespace

TEST_CASE("energy: what spins on a ball neither gains nor loses, and goes where it should",
          "[sim][energy]") {
  // a brick, and a rod that hangs by its end and turns about its long axis as well
  const auto [edges, spin] = GENERATE(std::pair(Vec3{0.045, 0.03, 0.012}, Vec3{12, -18, 9}),
                                      std::pair(Vec3{0.1, 0.004, 0.004}, Vec3{1, 5, 1.5}),
                                      std::pair(Vec3{0.1, 0.004, 0.004}, Vec3{8, 80, 24}));
  const double rate = GENERATE(200.0, 1000.0);
  const bool is_brick = edges.y > 0.01;
  const SpinningBrick brick(edges, spin, rate);
  BodySim sim(brick.scene);
  begin_with_twists(sim, {brick.V_WO});
  EnergyJudge judge({judged_box(0, edges, SpinningBrick::kMass)}, brick.scene.config.gravity_W,
                    rate);
  const Verdict first = run(sim, judge, 1);
  if (is_brick) {
    // of second order: some times (w dt)²/12 of the angle that it turns by, 25 rad
    const double w_dt = norm(spin) / rate;
    const double off =
        norm(to_rotation_vector(sim.frame.objects[0].X_WO.q * conjugate(spun(brick, 1))));
    CAPTURE(off, first.excess);
    CHECK(off < 10 * w_dt * w_dt / 12 * 25);
  }
  const Verdict verdict = run(sim, judge, 20 * seconds());
  CAPTURE(rate, norm(spin), is_brick, verdict.excess, verdict.swing, verdict.largest_kinetic,
          verdict.start, verdict.last_mean);
  CHECK(verdict.excess <= 0);
  CHECK(verdict.swing <= 1e-5 * verdict.largest_kinetic);
}

TEST_CASE("energy: a table with rising pieces gives back what it took", "[sim][energy]") {
  const double rate = GENERATE(200.0, 1000.0);
  const auto kind = GENERATE(JointKind::kHinge, JointKind::kSlider);
  CAPTURE(rate, static_cast<int>(kind));
  RodScene scene(kind);
  scene.config.sim_rate = rate;
  const bool is_hinge = kind == JointKind::kHinge;
  const double length = is_hinge ? 1.0 : 0.05;  // of a hill [rad] or [m]
  set_hills(scene.joint, 0.02, length);
  scene.joint.stiffness = is_hinge ? 0.01 : 4.0;
  BodySim sim(scene);
  // over the first hill, and back by the spring: both pieces of the table, again and again
  EnergyJudge judge({judged_box(0, {0.1, 0.02, 0.02}, RodScene::kMass)}, {}, rate);
  auto coordinate = std::make_shared<PoseCoordinate>(scene.joint, sim.frame);
  judge.add_store([=](const SceneFrame& frame) {
    // the table's points are of a sine: its integral, but for the spline's own error
    const double q = coordinate->at(frame), top = 1.5 * length;
    const double inside = std::clamp(q, -top, top);
    const double sine = std::sin(kPi * inside / length);
    return 0.02 * sine * sine + 0.5 * scene.joint.stiffness * q * q;
  });
  const double speed = is_hinge ? 9.0 : 0.6;
  const Twist V = is_hinge ? Twist{{0, speed * RodScene::kLength / 2, 0}, {0, 0, speed}}
                           : Twist{{0, 0, speed}, {}};
  begin_at(sim, scene.config.objects[0].X_WO, V, 0);
  const Verdict verdict = run(sim, judge, 2 * seconds());
  CAPTURE(verdict.excess, verdict.largest_kinetic, verdict.start, verdict.last_mean);
  CHECK(verdict.excess <= 0);
  CHECK(verdict.last_mean == Approx(verdict.start).epsilon(0.01));
}

TEST_CASE("energy: a bead in a bowl of wire rolls on for ever", "[sim][energy]") {
  const double rate = GENERATE(200.0, 1000.0);
  RodScene scene(JointKind::kCurve);
  scene.config.sim_rate = rate;
  constexpr double kRadius = 0.1;
  const Vec3 start = scene.config.objects[0].X_WO.p;
  scene.joint.at_W = start;
  scene.joint.n_points = 16;
  for (uint32_t i = 0; i < 16; ++i) {
    const double a = kPi * (i + 1) / 16;
    scene.joint.points_W[i] = start + kRadius * Vec3{1 - std::cos(a), 0, -std::sin(a)};
  }
  scene.config.gravity_W = {0, 0, -kGravity};
  BodySim sim(scene);
  begin_at(sim, scene.config.objects[0].X_WO, {}, 0);
  EnergyJudge judge({judged_box(0, {0.1, 0.02, 0.02}, RodScene::kMass)}, scene.config.gravity_W,
                    rate);
  // from a fifth of the way down, so that it stays away from the ends of the wire
  judge.begin(sim.frame);
  while (sim.frame.joints[0].position < 0.2 * kRadius * kPi) judge.add(sim.step());
  begin_at(sim, sim.frame.objects[0].X_WO, {}, sim.frame.joints[0].position);
  sim.t_ns = sim.frame.t_ns;
  EnergyJudge swinging({judged_box(0, {0.1, 0.02, 0.02}, RodScene::kMass)}, scene.config.gravity_W,
                       rate);
  const Verdict verdict = run(sim, swinging, 2 * seconds());
  CAPTURE(verdict.excess, verdict.largest_kinetic, verdict.start, verdict.last_mean);
  CHECK(judge.excess() <= 0);
  CHECK(verdict.excess <= 0);
  CHECK(verdict.last_mean == Approx(verdict.start).margin(1e-3 * verdict.largest_kinetic));
}

namespace {

/// A scene made at random of boxes, hulls, joints and a floor, all disjoint at its start.
struct RandomScene {
  BodyScene scene;
  std::vector<JudgedBody> judged;
  std::vector<Twist> V_WO{{}};  // at the start

  RandomScene(uint64_t seed, double rate) {
    Random random(seed);
    scene.config.sim_rate = rate;
    if (random.index(4) != 0) scene.config.gravity_W = {0, 0, -kGravity};
    scene.add_box({1, 1, 0.02}, {{0, 0, -0.01}, {}}, 0).material.friction_dynamic =
        random.uniform(0, 0.8);
    const size_t n = 2 + random.index(6);
    for (size_t i = 0; i < n; ++i) add_body(random, i);
    for (uint32_t i = 1; i <= n; ++i) {
      if (random.index(2) == 0) add_joint(random, i);
    }
  }

 private:
  void add_body(Random& random, size_t i) {
    const auto k = static_cast<double>(i);
    // in cells of 90 mm, and no body is longer than 80 across
    const Vec3 p{0.09 * (std::fmod(k, 3) - 1), 0.09 * (std::floor(k / 3) - 1),
                 0.05 + random.uniform(0, 0.05)};
    const Pose X{p, from_rotation_vector(random.uniform(0, 3) * random.direction())};
    const double mass = std::pow(10, random.uniform(-3, 0));
    const Vec3 edges = random.in_box({0.01, 0.01, 0.01}, {0.045, 0.045, 0.045});
    ObjectConfig& object = scene.add_box(edges, X, mass);
    object.material.friction_dynamic = random.uniform(0, 0.8);
    object.body.restitution = random.index(2) == 0 ? 0 : random.uniform(0, 1);
    judged.push_back(judged_box(scene.config.n_objects - 1, edges, mass));
    V_WO.push_back(
        {random.uniform(0, 0.3) * random.direction(), random.uniform(0, 10) * random.direction()});
  }
  void add_joint(Random& random, uint32_t object) {
    constexpr std::array kKinds{JointKind::kHinge, JointKind::kSlider, JointKind::kBall,
                                JointKind::kCylinder, JointKind::kFixed};
    JointConfig& joint = scene.config.joints[scene.config.n_joints++];
    joint.kind = kKinds[random.index(kKinds.size())];
    joint.object = object;
    joint.to = random.index(2) == 0 || object < 2 ? kToWorld : object - 1;
    joint.axis_W = random.direction();
    const Pose& X = scene.config.objects[object].X_WO;
    joint.at_W = X.p + random.uniform(0, 0.05) * random.direction();
    const bool is_spring = joint.kind == JointKind::kHinge || joint.kind == JointKind::kSlider;
    if (!is_spring || random.index(2) == 0) return;
    const double mass = scene.config.objects[object].body.mass;
    joint.stiffness =
        (joint.kind == JointKind::kHinge ? 1e-3 : 1.0) * mass * std::pow(10, random.uniform(1, 5));
    if (random.index(2) == 0) joint.damping = 1e-3 * joint.stiffness;
  }
};

}  // namespace

TEST_CASE("energy: scenes at random gain none", "[sim][energy]") {
  const size_t n = std::min<size_t>(sweep(8), 100);
  const double rate = GENERATE(200.0, 1000.0);
  for (uint64_t seed = 1; seed <= n; ++seed) {
    const RandomScene made(seed, rate);
    BodySim sim(made.scene);
    EnergyJudge judge(made.judged, made.scene.config.gravity_W, rate);
    for (uint32_t i = 0; i < made.scene.config.n_joints; ++i) {
      const JointConfig& joint = made.scene.config.joints[i];
      if (joint.stiffness > 0) judge.add_store(spring_of(joint, sim.frame));
    }
    begin_with_twists(sim, made.V_WO);
    const Verdict verdict = run(sim, judge, seconds());
    const double over = verdict.excess / verdict.largest_kinetic;
    CAPTURE(seed, rate, over, made.scene.config.gravity_W.z);
    CHECK(over <= 0);
  }
}
