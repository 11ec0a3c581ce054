// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/render/body_solver.cpp: ticks of a tool that never enters an object, on
// hand-made contacts.
#include <limits>

#include "proto/math/units.h"
#include "proto/wire/renderer.h"
#include "servo/render/body_solver.h"
#include "tests/support/near.h"
#include "tests/support/rigid_tick.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kStiffness = 800;

ServoModel rigid_model() {
  ServoModel model = plain_model(kStiffness);
  model.coupling = {kStiffness, 0, 2, 0};
  return model;
}

/// A box with its bottom at the tool's origin, on the floor z = 0.
std::unique_ptr<ContactSet> floor_set(Renderer renderer) {
  auto set = rigid_set({}, corners_on_floor(0.02, 0));
  set->renderer = static_cast<uint32_t>(renderer);
  return set;
}

/// Ticks with a new set each.
class RigidSession {
 public:
  explicit RigidSession(const ContactSet& set) : set_(std::make_unique<ContactSet>(set)) {}
  ServoModel model = rigid_model();
  ServoState state;
  ContactSet& set() { return *set_; }

  ServoFrame tick(const Vec3& p_W, const Vec3& v_W = {}, const ControlFrame* control = nullptr) {
    ++k_;
    if (answers) {
      set_->seq = static_cast<uint64_t>(k_);
      set_->answers_t_ns = (k_ - 1) * kMs;
    }
    ServoInput input = input_at(k_, p_W, set_.get());
    input.device.V_BH.v = v_W;
    input.control = control;
    input.scene = scene;
    return step_armed(model, state, input);
  }
  bool answers = true;  // whether contact answers
  const SceneFrame* scene = nullptr;

 private:
  std::unique_ptr<ContactSet> set_;
  int64_t k_ = 0;
};

}  // namespace

TEST_CASE("servo: a tool that never enters an object feels the coupling alone", "[servo]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  const SceneFrame scene = still_scene(1);
  session.scene = &scene;
  session.model.coupling.translational_damping = 2;
  const double depth = 1e-3;
  ServoFrame f{};
  for (int i = 0; i < 2000; ++i) f = session.tick({0, 0, -depth});
  CHECK_THAT(f.F_device_B.f, IsNear({0, 0, kStiffness * depth}, 1e-7));
  CHECK_THAT(f.X_WP.p, IsNear({}, 1e-9));
  CHECK(f.X_WG == session.set().X_WG);
  CHECK((f.flags & kServoContact) != 0);
  CHECK((f.flags & kServoSolverLimit) == 0);
  CHECK(f.n_contacts >= 1);
  // the objects are pushed with the force that the hand feels
  const Wrench before = session.state.pushes.objects[0].impulse_W;
  f = session.tick({0, 0, -depth});
  const Wrench after = session.state.pushes.objects[0].impulse_W;
  CHECK_THAT((after.f - before.f) / 1e-3, IsNear(-f.F_coupling_W.f, 1e-6));
  CHECK_THAT((after.t - before.t) / 1e-3, IsNear(-f.F_coupling_W.t, 1e-6));
}

TEST_CASE("servo: what a rigid tool meets without the hand's motion comes slowly", "[servo]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  session.model.limits.slew = 100;
  ServoFrame f{};
  double last = 0;
  for (int i = 0; i < 200; ++i) {
    f = session.tick({0, 0, -5e-3});
    REQUIRE(norm(f.F_device_B.f) - last <= 0.1 * (1 + 1e-9));
    last = norm(f.F_device_B.f);
  }
  CHECK(last > 1);
  CHECK((f.flags & kServoSlewing) == 0);
}

TEST_CASE("servo: contacts that come and go at once are felt as a ramp", "[servo][trap]") {
  RigidSession session(*floor_set(Renderer::kGodObject6));
  const double depth = 5e-3, full = kStiffness * depth, most = kMostForceRate * session.model.dt;
  const auto corners = session.set().contacts;
  session.set().contacts.clear();
  double before = session.tick({0, 0, -depth}).F_coupling_W.f.z;
  CHECK(before == 0);
  const auto follow = [&](int ticks, double target) {
    for (int i = 0; i < ticks; ++i) {
      const double now = session.tick({0, 0, -depth}).F_coupling_W.f.z;
      REQUIRE(std::fabs(now - before) <= most * (1 + 1e-9));
      REQUIRE(std::fabs(target - now) <= std::fabs(target - before));
      before = now;
    }
    CHECK(before == Approx(target));
  };
  session.set().contacts = corners;
  follow(static_cast<int>(full / most) + 1, full);
  // the surface moves up and down from one set to the next
  for (const double height : {3e-3, -3e-3}) {
    session.set().X_WG.p.z = height;
    for (uint32_t i = 0; i < 4; ++i) session.set().contacts[i].object_point_O.z = height;
    follow(20, full + kStiffness * height);
  }
  session.set().contacts.clear();
  follow(20, 0);
  CHECK(before == 0);
}

TEST_CASE("servo: a plane in place of another turns the force, with friction too",
          "[servo][trap]") {
  // 4 N on a floor that becomes a ramp: where planes meet at a sharp angle the proxy slides far
  const double depth = 5e-3, full = kStiffness * depth;
  const double angle = GENERATE(0.5, 0.7, 1.0, 1.3), mu = GENERATE(0.0, 0.05, 0.3);
  const Vec3 slope{std::sin(angle), 0, std::cos(angle)};
  auto floor = rigid_set({}, {{{}, {0, 0, 1}, 0}}), ramp = rigid_set({}, {{{}, slope, 0}});
  floor->renderer = ramp->renderer = static_cast<uint32_t>(Renderer::kGodObject6);
  RigidSession session(*floor);
  MaterialConfig& material = session.model.materials.of_object[0];
  material.friction_static = material.friction_dynamic = mu;
  for (int i = 0; i < 20; ++i) session.tick({0, 0, -depth * std::min(i / 10.0, 1.0)});
  Vec3 before = session.tick({0, 0, -depth}).F_device_B.f;
  CHECK_THAT(before, IsNear({0, 0, full}, 1e-6));
  session.set() = *ramp;
  double largest = 0;
  ServoFrame f{};
  for (int i = 0; i < 40; ++i) {
    f = session.tick({0, 0, -depth});
    largest = std::max(largest, norm(f.F_device_B.f - before));
    before = f.F_device_B.f;
  }
  CAPTURE(angle, mu);
  CHECK(largest <= kMostForceRate * session.model.dt * (1 + 1e-9));
  // in the end it is the force of the ramp alone: at the edge of its cone, or where it was held
  const double normal = dot(before, slope);
  const double tangential = norm(before - normal * slope);
  CHECK(normal > 0);
  CHECK(tangential <= mu * normal * (1 + 1e-6) + 1e-9);
  CHECK(normal == Approx(full * slope.z).epsilon(1e-6));
}

TEST_CASE("servo: friction of a rigid tool is its object's, and contact hears of it", "[servo]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  for (const double mu : {0.0, 0.5}) {
    MaterialConfig& material = session.model.materials.of_object[0];
    material.friction_static = material.friction_dynamic = mu;
    session.state = {};
    session.model.coupling.translational_damping = 2;
    for (int i = 0; i < 500; ++i) session.tick({0, 0, -1e-3});
    ServoFrame f{};
    for (int i = 0; i < 2000; ++i) f = session.tick({1e-6 * std::min(i, 400), 0, -1e-3});
    const double expected = mu > 0 ? -kStiffness * 4e-4 : 0;
    CHECK(f.F_coupling_W.f.x == Approx(expected).margin(1e-4));
    if (renderer == Renderer::kGodObject6) {
      CHECK(f.held_back_W.x == Approx(mu > 0 ? -4e-4 : 0).margin(1e-9));
    }
  }
}

TEST_CASE("servo: contacts of a rigid tool that are not finite are a fault", "[servo]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  session.tick({0, 0, -1e-3});
  session.set().contacts[1].object_point_O.z = std::numeric_limits<double>::quiet_NaN();
  const ServoFrame f = session.tick({0, 0, -1e-3});
  CHECK(f.F_device_B == Wrench{});
  CHECK(f.fault == static_cast<uint32_t>(Fault::kContactsNotFinite));
  CHECK(is_finite(f.X_WP));
}

TEST_CASE("servo: a rigid tool fades when contact falls silent", "[servo][trap]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  session.model.coupling.translational_damping = 2;
  ServoFrame f{};
  for (int i = 0; i < 1000; ++i) f = session.tick({0, 0, -5e-3});
  double before = f.F_device_B.f.z;
  CHECK(before == Approx(4));
  session.answers = false;
  bool stale = false;
  for (int i = 0; i < 3000; ++i) {
    f = session.tick({0, 0, -5e-3});
    // a fiftieth of the force per tick, plus the effect of the mass and its damper
    REQUIRE(std::fabs(f.F_device_B.f.z - before) < 0.2);
    before = f.F_device_B.f.z;
    stale |= (f.flags & kServoStale) != 0;
  }
  CHECK(stale);
  CHECK(std::fabs(before) < 1e-6);
}

TEST_CASE("servo: rigid tools begin anew where nothing was felt, or another renderer ran",
          "[servo][trap]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  RigidSession session(*floor_set(renderer));
  const auto started = [&] {
    return is_started<haptic::GodObject6Solver>(session.state) ||
           is_started<haptic::Constrained6Solver>(session.state);
  };
  ControlFrame control{};
  control.armed = 1;
  control.translational_stiffness = kStiffness;
  control.rotational_stiffness = 2;
  for (int i = 0; i < 20; ++i) session.tick({0, 0, -1e-3}, {}, &control);
  CHECK(started());
  // while paused, the proxy follows the hand as far as the contacts permit
  control.paused = 1;
  const ServoFrame f = session.tick({0.01, 0, -1e-3}, {}, &control);
  CHECK(f.F_device_B == Wrench{});
  CHECK_FALSE(started());
  CHECK_THAT(session.tick({0.02, 0, -1e-3}, {}, &control).X_WP.p, IsNear({0.02, 0, 0}, 1e-6));
  control.paused = 0;
  session.tick({0, 0, -1e-3}, {}, &control);
  CHECK(started());
  for (const Renderer other : {Renderer::kVoxel, Renderer::kGodObject3}) {
    session.set().renderer = static_cast<uint32_t>(other);
    session.tick({0, 0, 1e-3}, {}, &control);
    CHECK_FALSE(started());
    session.set().renderer = static_cast<uint32_t>(renderer);
    session.tick({0, 0, 1e-3}, {}, &control);
    CHECK(started());
    CHECK_FALSE(is_started<haptic::SoftProxySolver>(session.state));
  }
}
