// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/solve/body/free_space.cpp, and for its effect on a body's proxy.
#include "servo/solve/body/free_space.h"

#include <limits>
#include <memory>

#include "proto/wire/renderer.h"
#include "servo/step.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kSpeed = 2e-3;  // per tick [m]
constexpr double kHalfBand = 0.25e-3;

/// No contacts, and that much free distance around the tool.
std::unique_ptr<ContactSet> empty_set(double clearance) {
  auto set = set_of({});
  set->renderer = static_cast<uint32_t>(Renderer::kVoxel);
  set->tool = {0.1, {1e-4, 1e-4, 1e-4}, {}, 0.02};
  set->objects[0].clearance = clearance;
  return set;
}

ServoModel voxel_model() {
  ServoModel model = plain_model(800);
  model.soft.max_travel = kHalfBand;
  model.coupling.rotational_stiffness = 1;
  return model;
}

/// A hand that moves along x and rotates about it, with answers `age` ticks late.
class LateLoop {
 public:
  LateLoop(double clearance, int64_t age, double turn)
      : set_(empty_set(clearance)), age_(age), turn_(turn) {}

  ServoFrame tick() {
    ++k_;
    set_->X_WG = set_->X_WT = hand(k_ - age_);
    set_->seq = static_cast<uint64_t>(k_);
    set_->answers_t_ns = (k_ - age_) * kMs;
    ServoInput input = input_at(k_, {}, set_.get());
    input.device.X_BH = hand(k_);
    return step_armed(model_, state_, input);
  }
  Pose hand(int64_t k) const {
    const auto t = static_cast<double>(k);
    return {{kSpeed * t, 0, 0}, from_rotation_vector({turn_ * t, 0, 0})};
  }
  ContactSet& set() { return *set_; }

 private:
  ServoModel model_ = voxel_model();
  ServoState state_;
  std::unique_ptr<ContactSet> set_;
  int64_t age_, k_ = 20;
  double turn_;
};

/// The objects at these poses.
TickScene placed(std::span<const Pose> X_WO) {
  TickScene scene;
  for (const Pose& X : X_WO) scene.X_WO.push_back(X), scene.V_WO.push_back({});
  return scene;
}

}  // namespace

TEST_CASE("free space: what is left is what no point of the ball has moved", "[servo]") {
  Random random(17);
  const ToolBody tool{0.1, {1e-4, 1e-4, 1e-4}, {0.01, -0.02, 0.005}, 0.03};
  size_t n_free = 0;
  for (size_t trial = 0; trial < 2000; ++trial) {
    auto set = empty_set(random.uniform(0, 0.05));
    set->objects.resize(2);
    auto& seen = set->objects;
    std::array<Pose, 2> X_WO;
    const auto near = [&](const Pose& X, double size) {
      return Pose{X.p + size * random.direction(),
                  normalized(from_rotation_vector(20 * size * random.direction()) * X.q)};
    };
    for (size_t i = 0; i < 2; ++i) {
      seen[i].X_WO = near({}, 0.1);
      X_WO[i] = near(seen[i].X_WO, random.uniform(0, 0.01));
    }
    set->X_WG = near({}, 0.1);
    seen[1].clearance = random.uniform(0.5, 2) * seen[0].clearance;
    const Pose X_WT = near(set->X_WG, random.uniform(0, 0.02));
    const TickScene scene = placed(X_WO);
    const FreeSpace space(*set, tool, scene);
    const Pose X_WC = motion_of_centre(tool, {X_WT, {}}).X_WC;
    const double left = space.left_at(X_WC);
    if (!(left > 0)) continue;
    ++n_free;
    for (int k = 0; k < 20; ++k) {
      const Vec3 p_T = tool.centre_T + tool.radius * random.direction();
      for (size_t i = 0; i < 2; ++i) {
        const Vec3 then = inverse(seen[i].X_WO) * (set->X_WG * p_T);
        const Vec3 now = inverse(X_WO[i]) * (X_WT * p_T);
        REQUIRE(norm(now - then) + left <= seen[i].clearance + 1e-12);
      }
    }
  }
  CHECK(n_free > 200);
}

TEST_CASE("free space: a hand of 2 m/s and 10 rad/s feels exactly nothing, answers 20 ticks late",
          "[servo]") {
  const int64_t age = GENERATE(1, 2, 5, 20);
  LateLoop loop(0.05, age, 0.01);
  for (int k = 0; k < 100; ++k) {
    const ServoFrame f = loop.tick();
    REQUIRE(f.F_coupling_W == Wrench{});
    REQUIRE(f.F_device_B == Wrench{});
    REQUIRE(f.X_WP == f.X_WT);
  }
}

TEST_CASE("free space: a proxy with mass is not held back by its contacts' age", "[servo]") {
  ServoModel model = voxel_model();
  model.proxy.solver = SoftSolver::kPenaltyDynamics;
  model.limits.velocity_limit = 3;
  model.coupling.translational_damping = 10;
  ServoState state;
  const auto set = empty_set(0.05);
  // from rest to 2 m/s in 0.1 s: 20 m/s² of 0.1 kg
  const auto hand = [](int64_t k) {
    const double t = 1e-3 * static_cast<double>(std::max<int64_t>(k, 0));
    return Vec3{t < 0.1 ? 10 * t * t : 0.1 + 2 * (t - 0.1), 0, 0};
  };
  for (int64_t k = 1; k <= 200; ++k) {
    set->X_WG.p = hand(k - 20);
    set->seq = static_cast<uint64_t>(k);
    set->answers_t_ns = (k - 20) * kMs;
    ServoInput input = input_at(k, hand(k), set.get());
    input.device.V_BH.v = (hand(k) - hand(k - 1)) / 1e-3;
    const ServoFrame f = step_armed(model, state, input);
    REQUIRE(norm(f.F_coupling_W.f) < 4);
    if (k == 200) CHECK(norm(f.F_coupling_W.f) < 0.2);
  }
}

TEST_CASE("free space: beyond it the proxy goes its share of half a band a tick", "[servo]") {
  const int64_t age = 20;
  const double clearance = 0.01;
  LateLoop loop(clearance, age, 0);
  ServoFrame f{};
  for (int k = 0; k < 100; ++k) f = loop.tick();
  const double way = clearance + kHalfBand / static_cast<double>(age);
  CHECK_THAT(f.X_WP.p, IsNear(f.X_WG.p + Vec3{way, 0, 0}, 1e-12));
  CHECK_THAT(f.F_coupling_W.f, IsNear({-800 * (kSpeed * age - way), 0, 0}, 1e-8));
}

TEST_CASE("free space: while contact is away a hand is caught up with, however fast", "[servo]") {
  // faster than half a band a tick
  const double way = 1.2 * kHalfBand;
  const ServoModel model = voxel_model();
  ServoState state;
  const auto set = empty_set(0.001);
  double behind = 0;
  for (int64_t k = 1; k <= 200; ++k) {
    const Vec3 hand{way * static_cast<double>(k), 0, 0};
    const ServoFrame f = step_armed(model, state, input_at(k, hand, set.get()));
    behind = std::max(behind, f.depth);
    // the old set is rendered for 70 ms; the lag then decreases by half a band per tick
    if (static_cast<double>(k) > 70 + behind / kHalfBand + 1) REQUIRE(f.F_coupling_W == Wrench{});
  }
  CHECK(behind > 10 * kHalfBand);
  CHECK(70 + behind / kHalfBand < 180);
}

TEST_CASE("free space: what an object has moved is used up", "[servo]") {
  auto set = empty_set(0.05);
  std::array<Pose, 1> X_WO;
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({}) == Approx(0.05));
  X_WO[0].p.x = 0.01;
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({}) == Approx(0.04));
  // a tool that moves along with the object uses up nothing
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({{0.01, 0, 0}, {}}) == Approx(0.05));
}

TEST_CASE("free space: an object far away that moves uses up its own clearance alone", "[servo]") {
  auto set = empty_set(0.005);
  set->objects.push_back({{}, 0.4});
  std::array<Pose, 2> X_WO;
  X_WO[1].p.x = 0.02;
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({}) == Approx(0.005));
  X_WO[1].p.x = 0.398;
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({}) == Approx(0.002));
  // no free space if the place or the clearance of an object is unknown, or without objects
  CHECK_FALSE(FreeSpace(*set, {}, placed(std::span(X_WO).first(1))).left_at({}) > 0);
  set->objects[0].clearance = 0;
  CHECK_FALSE(FreeSpace(*set, {}, placed(X_WO)).left_at({}) > 0);
  set->objects.clear();
  CHECK_FALSE(FreeSpace(*set, {}, placed(X_WO)).left_at({}) > 0);
}

TEST_CASE("free space: nothing that is not a number makes a place free", "[servo][trap]") {
  auto set = empty_set(1);
  const std::array<Pose, 1> X_WO{};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(FreeSpace(*set, {}, placed(X_WO)).left_at({}) > 0);
  set->X_WG.p.x = nan;
  CHECK_FALSE(FreeSpace(*set, {}, placed(X_WO)).left_at({}) > 0);
  set->X_WG.p.x = 0;
  CHECK_FALSE(FreeSpace(*set, {}, placed(X_WO)).left_at({{nan, 0, 0}, {}}) > 0);
  set->objects[0].clearance = nan;
  CHECK_FALSE(FreeSpace(*set, {}, placed(X_WO)).left_at({}) > 0);
}

TEST_CASE("free space: a plane of a client ends it", "[servo]") {
  auto set = empty_set(0.05);
  Contact plane{};
  plane.object = kNoObject;
  plane.giver = moved_by_client(2);
  plane.normal_O = {0, 0, 1};
  plane.object_point_O.z = -0.02;
  plane.tool_point_T.z = -0.005;
  set->contacts.push_back(plane);
  TickScene scene = placed(std::array<Pose, 1>{});
  PlacedSurfaces kept;
  scene.place_surfaces(*set, kept);
  CHECK(FreeSpace(*set, {}, scene).left_at({}) == Approx(0.015));
  CHECK_FALSE(FreeSpace(*set, {}, scene).left_at({{0, 0, -0.016}, {}}) > 0);
  // beside where it holds it ends nothing
  set->contacts[0].extent = 0.01;
  CHECK(FreeSpace(*set, {}, scene).left_at({{0.03, 0, -0.016}, {}}) > 0);
}
