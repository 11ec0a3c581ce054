// SPDX-License-Identifier: GPL-3.0-or-later
// A grasp by a tool with six degrees of freedom, with each kind of renderer, and the scene `carry`.
#include <catch2/catch.hpp>

#include "contact/bake/session.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/guide.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"
#include "tests/clients/lab/support/pushed_body.h"
#include "tests/support/data.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kTool = 0.01;                         // edge of the tool, a cube [m]
constexpr double kStart = 0.02 - 0.5 * kTool - 10e-6;  // of the hand: 10 µm before the box [m]
constexpr double kWay = 0.05, kTurn = 0.4;             // of the hand [m], [rad]

/// A hand that presses its button at once, then goes back by kWay and turns by kTurn.
class CarryingHand : public PushingHand {
 public:
  CarryingHand(double start, double max_torque)
      : PushingHand(model(start)), max_torque_(max_torque) {}
  DeviceCaps caps() const override {
    DeviceCaps caps = PushingHand::caps();
    caps.max_torque = max_torque_;
    return caps;
  }
  bool read(const TickTime& tick, DeviceState& state) override {
    const bool is_new = PushingHand::read(tick, state);
    turn_ = rise(0, kTurn, 0.3)(1e-3 * ticks_++ - 0.25);
    state.X_BH.q = from_rotation_vector({turn_, 0, 0});
    return is_new;
  }
  double turn() const { return turn_; }

 private:
  static HandModel model(double start) {
    HandModel hand;
    hand.x = start;
    hand.damping = 20;
    hand.intent = [moves = rise(start, -kWay, 0.4)](double t) { return moves(t - 0.05); };
    hand.presses = [](double t) { return t > 0.01; };
    return hand;
  }
  double max_torque_;
  double turn_ = 0;
  int ticks_ = 0;
};

/// A hand in the box's face that nothing stops, with its button down.
HandModel unstoppable_hand() {
  HandModel model;
  model.mass = 1e6;
  model.stiffness = model.damping = 0;
  model.x = kFace + 0.1e-3;
  model.presses = [](double t) { return t > 0.01; };
  return model;
}

constexpr double kHanging = 0.1;  // mass of a body that hangs from the hand [kg]

/// It lies on what is behind it until it is taken.
PushedSession hanging_session() {
  PushedSession session(kHanging, 800);
  session.config.map.grasp_button = 0;
  session.config.gravity_W = {kGravity, 0, 0};
  session.add_box({kBoxEdge, 0.1, 0.1}, {0.03 + kBoxEdge, 0, 0}, 0);
  return session;
}

/// The hand takes it so far [mm] off, and waits until it hangs still.
void hang_still(Pushed& pushed, double damping, int lift = 20) {
  Lockstep& lockstep = pushed.lockstep;
  felt(lockstep, 300);
  pushed.hand.move_at(-0.02);
  felt(lockstep, 50 * lift);
  pushed.hand.move_at(0);
  // what it swings by has no damper but this
  lockstep.control().translational_damping = 5;
  felt(lockstep, 1500);
  lockstep.control().translational_damping = damping;
  felt(lockstep, 500);
}

/// The most that the force differs from `before` in so many ticks.
double most_change(Lockstep& lockstep, double before, int n_ticks) {
  double most = 0;
  for (int k = 0; k < n_ticks; ++k) {
    REQUIRE(lockstep.step());
    most = std::max(most, std::fabs(lockstep.frame().F_coupling_W.f.x - before));
  }
  return most;
}

}  // namespace

TEST_CASE("grasp: a tool with six degrees of freedom carries a body, and turns it if it feels that",
          "[grasp]") {
  const Renderer renderer =
      GENERATE(Renderer::kGodObject6, Renderer::kConstrained6, Renderer::kDirect6, Renderer::kVoxel,
               Renderer::kLocalized, Renderer::kSensation);
  const uint32_t latency = GENERATE(0u, 2u);
  const double max_torque = GENERATE(1e3, 0.0);  // of the device
  CAPTURE(row_of(renderer).name, latency, max_torque);
  constexpr double kMass = 0.1;
  PushedSession session(kMass, 800);
  SessionConfig& config = session.config;
  config.renderer = renderer;
  config.map.grasp_button = 0;
  config.coupling.translational_damping = 1;
  config.coupling.rotational_stiffness = 0.5;
  config.coupling.rotational_damping = 1e-3;
  config.safety.max_torque = 1e3;
  config.safety.torque_slew = 1e6;
  config.safety.angular_velocity_limit = 1e3;
  config.proxy.solver = SoftSolver::kQuasiStatic;
  config.tool.primitive = primitive::Box{{kTool, kTool, kTool}};
  config.tool.mass = 0.02;
  config.voxel.offset_layers = 0;
  const BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  // bodies that enter each other have no contact before they do
  const bool may_enter = row_of(renderer).moves == Moves::kSoftBody;
  CarryingHand hand(may_enter ? kStart + 0.1e-3 : kStart, max_torque);
  LockstepOptions options;
  options.scene_latency = latency;
  Lockstep lockstep(config, shapes, hand, options);
  std::vector<double> force;
  double most_turn = 0;
  Vec3 given{};
  for (int k = 0; k < 800; ++k) {
    REQUIRE(lockstep.step());
    force.push_back(lockstep.frame().F_coupling_W.f.x);
    given += -1e-3 * lockstep.frame().F_coupling_W.f;
    most_turn = std::max(most_turn, norm(lockstep.frame().F_coupling_W.t));
    REQUIRE((lockstep.frame().flags & kServoFault) == 0);
  }
  const ContactSet& set = *lockstep.contacts();
  CHECK(set.guides.size() == 6);
  const Pose& X_WO = lockstep.scene().objects[0].X_WO;
  const Twist& V_WO = lockstep.scene().objects[0].V_WO;
  CAPTURE(X_WO.p.x, hand.hand().x, most_turn, force.back());
  if (max_torque == 0) {
    // a twist that nobody feels turns nothing
    CHECK(norm(to_rotation_vector(X_WO.q)) < 0.02);
    return;
  }
  // it lies against the tool, as it did
  CHECK(std::fabs(X_WO.p.x - hand.hand().x - 0.5 * (kTool + kBoxEdge)) < 1e-3);
  CHECK(std::fabs(to_rotation_vector(X_WO.q).x - hand.turn()) < 0.02);
  CHECK(most_turn > 1e-4);
  CHECK(norm(V_WO.w) < 0.05);
  CHECK(largest_step(force, 200) < 0.02);
  // a massless proxy gives what the hand gives, and the body has what sim has seen of it
  const Vec3 seen = seen_of(lockstep.scene(), 0, kFirstHand)->impulse_W.f;
  if (renderer != Renderer::kGodObject6) return;
  CHECK(norm(given - lockstep.frame().pushes[0].impulse_W.f) < 1e-12);
  CHECK(norm(seen - kMass * V_WO.v) < 1e-9 * kMass);
}

TEST_CASE("grasp: a resting hand does not notice that sim stands still or dies", "[grasp]") {
  const int outage = GENERATE(5, 25, 35, 45, 65, 200);  // [ms]
  const bool is_killed = GENERATE(false, true);
  const double damping = GENERATE(0.0, 2.0);
  CAPTURE(outage, is_killed, damping);
  Pushed pushed(hanging_session(), unstoppable_hand());
  Lockstep& lockstep = pushed.lockstep;
  hang_still(pushed, damping);
  const double before = lockstep.frame().F_coupling_W.f.x;
  CHECK(before == Approx(kHanging * kGravity).epsilon(0.01));
  lockstep.stop_sim();
  double most = most_change(lockstep, before, outage);
  is_killed ? lockstep.restart_sim() : lockstep.continue_sim();
  most = std::max(most, most_change(lockstep, before, 1500));
  CAPTURE(before, most);
  CHECK(most <= 0.2);
}

TEST_CASE("grasp: a resting hand does not notice that a new sim's segment is mapped late",
          "[grasp]") {
  const uint64_t ticks = GENERATE(5u, 15u, 40u);
  CAPTURE(ticks);
  Pushed pushed(hanging_session(), unstoppable_hand());
  Lockstep& lockstep = pushed.lockstep;
  hang_still(pushed, 2);
  const double before = lockstep.frame().F_coupling_W.f.x;
  lockstep.stop_sim();
  felt(lockstep, 40);
  lockstep.restart_sim(ticks);
  CHECK(most_change(lockstep, before, 1500) <= 0.1);
}

TEST_CASE("grasp: a resting hand does not notice that the servo misses ticks", "[grasp]") {
  const int missed = GENERATE(1, 4, 10);
  CAPTURE(missed);
  Pushed pushed(hanging_session(), unstoppable_hand());
  Lockstep& lockstep = pushed.lockstep;
  hang_still(pushed, 2);
  const double before = lockstep.frame().F_coupling_W.f.x;
  for (int k = 0; k < missed; ++k) lockstep.miss_tick();
  CHECK(most_change(lockstep, before, 1500) <= 0.01);
}

TEST_CASE("grasp: a body that falls while contact stands still is pulled no harder than before",
          "[grasp]") {
  // the hold catches it while it is slow, or what it has lain on does before it is fast
  const auto [outage, lift] = GENERATE(std::pair(30, 20), std::pair(45, 20), std::pair(60, 4),
                                       std::pair(100, 4), std::pair(150, 4));  // [ms], [mm]
  CAPTURE(outage, lift);
  Pushed pushed(hanging_session(), unstoppable_hand());
  Lockstep& lockstep = pushed.lockstep;
  hang_still(pushed, 3, lift);
  const double before = lockstep.frame().F_coupling_W.f.x;
  lockstep.stop_contact();
  felt(lockstep, outage);
  lockstep.continue_contact();
  double most = 0;
  for (int k = 0; k < 1500; ++k) {
    REQUIRE(lockstep.step());
    most = std::max(most, lockstep.frame().F_coupling_W.f.x);
  }
  CAPTURE(before, most);
  CHECK(most <= before + 0.2);
  CHECK(lockstep.frame().F_coupling_W.f.x == Approx(before).margin(0.02));
}

TEST_CASE("grasp: what the hand pulls while sim is away does not throw the body", "[grasp]") {
  constexpr double kMass = 0.1;
  const int outage = GENERATE(60, 200, 1000);  // [ms]
  CAPTURE(outage);
  PushedSession session(kMass, 800);
  session.config.map.grasp_button = 0;
  session.config.coupling.translational_damping = 2;
  Pushed pushed(session, unstoppable_hand());
  Lockstep& lockstep = pushed.lockstep;
  felt(lockstep, 500);
  lockstep.stop_sim();
  felt(lockstep, 25);
  pushed.hand.move_at(-0.3);
  felt(lockstep, outage);
  pushed.hand.move_at(0);
  lockstep.restart_sim();
  double fastest = 0;
  for (int k = 0; k < 8000; ++k) {
    REQUIRE(lockstep.step());
    fastest = std::max(fastest, norm(lockstep.scene().objects[0].V_WO.v));
  }
  // it comes after, at the speed at which the hold takes up what it gave way by
  const double apart = lockstep.scene().objects[0].X_WO.p.x - 0.03 - (pushed.hand.hand().x - kFace);
  CAPTURE(fastest, apart);
  CHECK(fastest < 0.2);
  CHECK(std::fabs(apart) < 2e-3);
}

TEST_CASE("scene carry: one block is lifted, laid on the other and brought back", "[grasp]") {
  const SessionConfig config = load_config(from_source("configs/carry.toml"));
  std::deque<MeshShapeData> owned;
  std::vector<MeshShape> shapes;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    owned.push_back(build_shape(make_mesh(config.objects[i].primitive)));
    shapes.push_back(owned.back().view());
  }
  const auto hand = open_device(config.device);
  Lockstep lockstep(config, shapes, *hand);
  const auto block = [&] { return lockstep.scene().objects[1].X_WO.p; };
  double highest = 0;
  for (int k = 0; k < 16'000 && lockstep.step(); ++k) {
    REQUIRE(norm(lockstep.frame().F_device_B.f) <= config.safety.max_force * (1 + 1e-9));
    highest = std::max(highest, block().y);
    if (k != 8'300) continue;
    // on the other, both at rest
    CHECK(highest > 0.06);
    CAPTURE(block().x, block().y, block().z);
    CHECK(norm(block() - Vec3{0.05, 0.045, 0}) < 5e-3);
    CHECK(std::fabs(block().y - 0.045) < 2e-4);
    CHECK(norm(lockstep.scene().objects[1].V_WO.v) < 1e-3);
  }
  CAPTURE(block().x, block().y, block().z);
  CHECK(norm(block() - Vec3{-0.05, 0.015, 0}) < 5e-3);
}
