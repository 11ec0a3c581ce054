// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies too light for the coupling, in the open, against a wall, in a corner and on a hinge:
// judged by the device's force, the hand's way and the body's speed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

enum class Place { kOpen, kWall, kCorner, kHinge, kStickingHinge };

PushedSession light_session(Place place, double mass, double stiffness) {
  PushedSession session(mass, stiffness);
  if (place == Place::kWall) {
    session.add_box({kBoxEdge, 0.1, 0.1}, {0.03 + kBoxEdge + 0.01, 0, 0}, 0);
  }
  if (place == Place::kCorner) session.add_corner();
  if (place == Place::kHinge || place == Place::kStickingHinge) {
    session.config.n_joints = 1;
    JointConfig& joint = session.config.joints[0];
    joint.kind = JointKind::kHinge;
    joint.at_W = {0.04, -0.05, 0};
    joint.lower = -0.3;
    joint.upper = 0.5;
    joint.friction = place == Place::kStickingHinge ? 0.002 : 0;
  }
  return session;
}

HandModel pressing_hand() {
  HandModel hand;
  hand.intent = rise(0, 0.05, 0.4);
  return hand;
}

struct Pressed {
  double most_kinetic = 0;  // of the body [J]
  double most_given = 0;    // by the hand [J]
  double rise = 0;  // largest of the force within a tick, once it has been felt for 50 ms [N]
  bool softened = false;
};

Pressed press(const PushedSession& session, double mass, uint32_t latency) {
  Pushed pushed(session, pressing_hand(), latency);
  const double inertia = mass * kBoxEdge * kBoxEdge / 6;
  Pressed out;
  double given = 0, last = 0;
  int felt = 0;
  for (int k = 0; k < 1500; ++k) {
    REQUIRE(pushed.lockstep.step());
    const Twist& V = pushed.lockstep.scene().objects[0].V_WO;
    out.most_kinetic =
        std::max(out.most_kinetic, 0.5 * mass * dot(V.v, V.v) + 0.5 * inertia * dot(V.w, V.w));
    const double force = -pushed.lockstep.frame().F_device_B.f.x;
    given += 1e-3 * force * pushed.hand.hand().v;
    out.most_given = std::max(out.most_given, given);
    felt += force > 0;
    if (felt > 50) out.rise = std::max(out.rise, force - last);
    last = force;
    out.softened |= (pushed.lockstep.frame().flags & kServoSoftened) != 0;
  }
  return out;
}

}  // namespace

TEST_CASE("light body: it has no more energy than the hand has given", "[pushed]") {
  const Place place = GENERATE(Place::kOpen, Place::kWall, Place::kCorner, Place::kHinge);
  const double stiffness = GENERATE(800.0, 5000.0), mass = GENERATE(0.001, 0.002, 0.005, 0.02);
  const uint32_t latency = GENERATE(0u, 1u, 2u);
  CAPTURE(static_cast<int>(place), stiffness, mass, latency);
  const Pressed pressed = press(light_session(place, mass, stiffness), mass, latency);
  CAPTURE(1e3 * pressed.most_kinetic, 1e3 * pressed.most_given, pressed.rise);
  CHECK(pressed.most_kinetic <= 1.02 * pressed.most_given + 10e-6);
  CHECK(pressed.rise < 1.5);
  // K (dt + dt)² / m of a push through its middle
  const double ratio = stiffness * 4e-6 / mass;
  if (place == Place::kOpen && ratio > 1.05) CHECK(pressed.softened);
  if (place == Place::kOpen && ratio < 0.95) CHECK_FALSE(pressed.softened);
}

TEST_CASE("light body: one that sticks and slips on its hinge is no series of spikes", "[pushed]") {
  const double mass = GENERATE(0.001, 0.002, 0.005);
  const uint32_t latency = GENERATE(0u, 1u, 2u);
  CAPTURE(mass, latency);
  const Pressed pressed = press(light_session(Place::kStickingHinge, mass, 5000), mass, latency);
  CAPTURE(1e3 * pressed.most_kinetic, 1e3 * pressed.most_given, pressed.rise);
  CHECK(pressed.rise < 2.5);
}
