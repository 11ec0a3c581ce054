// SPDX-License-Identifier: GPL-3.0-or-later
// Mechanisms that a hand pushes, in closed loop, against an integration of the same equations at
// 20 µs.
#include <catch2/catch.hpp>

#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kStep = 20e-6;      // of the integration [s]
constexpr double kLever = 0.1;       // from the hinge, which lies at x = 30 mm, y = −100 mm [m]
constexpr double kHalfDepth = 0.01;  // of the plate [m]
constexpr int kTicks = 700;

HandModel opening_hand() {
  HandModel hand;
  hand.intent = rise(0, 0.05, 0.4);
  return hand;
}

/// A plate that turns about z through the end of a lever, with its face towards the hand.
struct Hinged : PushedSession {
  Hinged(double mass, double stiffness, double lower) : PushedSession(0, stiffness) {
    config.n_objects = 0;
    owned.clear();
    shapes.clear();
    add_box({2 * kHalfDepth, 0.06, 0.06}, {0.03, 0, 0}, mass);
    config.n_joints = 1;
    config.joints[0].kind = JointKind::kHinge;
    config.joints[0].at_W = {0.03, -kLever, 0};
    config.joints[0].lower = lower;
  }
};

/// Hand, one-sided spring across the turning face, and inertia about the hinge; an end stop takes
/// all speed.
std::vector<double> integrate_hinge(HandModel hand, double stiffness, double mass, double lower) {
  const double depth = 2 * kHalfDepth, height = 0.06;
  const double inertia = mass / 12 * (depth * depth + height * height) + mass * kLever * kLever;
  std::vector<double> force;
  double q = 0, w = 0;
  for (int k = 0; k < 50 * kTicks; ++k) {
    const double c = std::cos(q), s = std::sin(q);
    // n = (−c, −s); the hand seen from the hinge: (x − 0.03, lever)
    const double away = hand.x - 0.03;
    const double deep = std::max(0.0, c * away + s * kLever + kHalfDepth);
    const double push = stiffness * deep;
    if (k % 50 == 0) force.push_back(c * push);
    hand.step(k * kStep, -c * push, kStep);
    w += kStep * push * (away * s - kLever * c) / inertia;
    q += kStep * w;
    if (q < lower) {
      q = lower;
      w = std::max(w, 0.0);
    }
  }
  return force;
}

std::vector<double> felt_by(const PushedSession& session, uint32_t latency) {
  Pushed pushed(session, opening_hand(), latency);
  return felt(pushed.lockstep, kTicks);
}

}  // namespace

TEST_CASE("pushed joint: a hinged body pushes back as one integrated at 20 µs does", "[pushed]") {
  const double mass = GENERATE(0.005, 0.05, 2.0);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(mass, latency);
  const Hinged session(mass, 800, -3);
  const double error =
      rms_error(felt_by(session, latency), integrate_hinge(opening_hand(), 800, mass, -3));
  CAPTURE(error);
  CHECK(error <= 0.05);
}

TEST_CASE("pushed joint: one that comes to lie against an end stop is a wall there", "[pushed]") {
  const double stiffness = GENERATE(800.0, 3000.0);
  const double mass = GENERATE(0.005, 0.05, 2.0);
  const double lower = GENERATE(0.0, -0.05);  // it lies there at the start, or comes to
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(stiffness, mass, lower, latency);
  const Hinged session(mass, stiffness, lower);
  const std::vector<double> force = felt_by(session, latency);
  const std::vector<double> exact = integrate_hinge(opening_hand(), stiffness, mass, lower);
  const double error = rms_error(force, exact);
  CAPTURE(error, largest_step(force, 200), largest_step(exact, 200));
  if (stiffness == 800.0) CHECK(error <= 0.2);
  CHECK(largest_step(force, 200) < 0.02 + 1.5 * largest_step(exact, 200));
}

TEST_CASE("pushed joint: a body on a spring of 500 N/m pushes back as it should", "[pushed]") {
  constexpr double kSupport = 500, kCalm = 1;  // [N/m], [N·s/m]
  const double stiffness = GENERATE(800.0, 3000.0);
  const double mass = GENERATE(0.005, 0.02, 2.0);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(stiffness, mass, latency);
  PushedSession session(mass, stiffness);
  JointConfig& joint = session.config.joints[0];
  session.config.n_joints = 1;
  joint.kind = JointKind::kSlider;
  joint.axis_W = {1, 0, 0};
  joint.stiffness = kSupport;
  joint.damping = kCalm;
  const std::vector<double> force = felt_by(session, latency);
  std::vector<double> exact;
  HandModel hand = opening_hand();
  double x = 0, v = 0;
  for (int k = 0; k < 50 * kTicks; ++k) {
    const double push = stiffness * std::max(0.0, hand.x - x - 0.02);
    if (k % 50 == 0) exact.push_back(push);
    hand.step(k * kStep, -push, kStep);
    v += kStep * (push - kSupport * x - kCalm * v) / mass;
    x += kStep * v;
  }
  const double error = rms_error(force, exact);
  CAPTURE(error, largest_step(force, 200), largest_step(exact, 200));
  if (stiffness == 800.0) CHECK(error <= 0.2);
  CHECK(largest_step(force, 200) < 0.02 + 1.5 * largest_step(exact, 200));
}

TEST_CASE("pushed joint: at rest a damper takes nothing of what a spring holds", "[pushed]") {
  constexpr double kSpring = 1000;  // each side [N/m]
  const double mass = GENERATE(0.005, 0.02, 0.2);
  const double damping = GENERATE(1.0, 5.0, 20.0);
  const uint32_t latency = GENERATE(0u, 1u, 2u);
  const bool is_chain = GENERATE(false, true);  // the slider leads to a body that is fixed
  CAPTURE(mass, damping, latency, is_chain);
  PushedSession session(mass, kSpring);
  session.config.n_joints = is_chain ? 2 : 1;
  JointConfig& joint = session.config.joints[0];
  joint.kind = JointKind::kSlider;
  joint.axis_W = {1, 0, 0};
  joint.stiffness = kSpring;
  joint.damping = damping;
  if (is_chain) {
    session.add_box({kBoxEdge, kBoxEdge, kBoxEdge}, {0.1, 0, 0}, 0.1);
    joint.to = 1;
    session.config.joints[1].kind = JointKind::kFixed;
    session.config.joints[1].object = 1;
    session.config.joints[1].at_W = {0.1, 0, 0};
  }
  // a hand that nothing stops goes 6 mm beyond the face, and stands still
  HandModel hand;
  hand.mass = 1e6;
  hand.stiffness = hand.damping = 0;
  hand.x = kFace - 0.001;
  hand.v = 0.02;
  Pushed pushed(session, hand, latency);
  felt(pushed.lockstep, 350);
  pushed.hand.move_at(0);
  const double exact = kSpring / 2 * (pushed.hand.hand().x - kFace);
  const std::vector<double> force = felt(pushed.lockstep, 1'500);
  CAPTURE(exact, force.back(), largest_step(force, 200));
  CHECK(exact == Approx(3).epsilon(0.01));
  CHECK(force.back() == Approx(exact).epsilon(0.005));
  CHECK(largest_step(force, 200) < 0.001 * exact);
}
