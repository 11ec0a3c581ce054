// SPDX-License-Identifier: GPL-3.0-or-later
// An admittance device that is paused, disarmed, re-indexed by its clutch, lost or held for a
// while: the command never jumps, and a hand that pushes moves the body again afterwards.
#include <algorithm>

#include "contact/bake/session.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/arm_session.h"
#include "tests/support/data.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kMass = 2;
constexpr double kForce = 20;  // of the hand, at most [N]

/// A simulated arm with a button, whose cable may come off: then its last pose is held. Something
/// may hold the arm itself, too.
class ArmWithCable final : public Device {
 public:
  ArmWithCable(const DeviceConfig& config, Intention intention)
      : arm_(config, std::move(intention)) {}

  DeviceCaps caps() const override { return arm_.caps(); }
  std::string description() const override { return arm_.description(); }
  bool read(const TickTime& tick, DeviceState& state) override {
    DeviceState now{};
    const bool is_new = arm_.read(tick, now);
    now.buttons = buttons;
    if (is_lost) {
      state = seen_;
      state.flags |= kDeviceLost | kDeviceHeld;
      return false;
    }
    seen_ = state = now;
    return is_new;
  }
  void write(const Wrench&) override {}
  void move(const Pose& X_BH) override {
    if (!is_lost && !is_held) arm_.move(X_BH);
  }
  void stop() override { arm_.stop(); }
  /// Somebody moves the arm while its cable is off.
  void carry_to(const Pose& X_BH) { arm_.move(X_BH); }

  bool is_lost = false, is_held = false;
  uint32_t buttons = 0;

 private:
  SimulatedArm arm_;
  DeviceState seen_{};
};

/// A hand that pushes along x with 20 N at first, in free space.
struct FreeRun {
  SessionConfig config;
  MeshShapeData block = build_shape(make_box({0.1, 0.1, 0.1}));
  ArmWithCable arm;
  Lockstep lockstep;
  Pose last;
  double longest = 0;  // way of the command in a tick [m]

  static SessionConfig session() {
    SessionConfig out = arm_session(Renderer::kGodObject3);
    out.safety.max_force = out.device.max_force = kForce;
    out.device.admittance.mass = kMass;
    out.device.hand.hand_stiffness = 100;
    out.device.hand.hand_damping = 5;
    out.device.hand.hand_mass = 0.2;
    out.objects[0].X_WO.p = {3, 3, 3};
    out.map.clutch_button = 0;
    return out;
  }
  static Intent ahead(double t) {
    Intent intent;
    intent.p_B = {t < 0.01 ? 0 : 0.5, 0, 0};
    return intent;
  }
  FreeRun()
      : config(session()),
        arm(config.device, ahead),
        lockstep(config, ContactShapes(std::array{block.view()}), arm) {}

  const ServoFrame& step(int n = 1) {
    for (int k = 0; k < n; ++k) {
      lockstep.step();
      const Pose& now = lockstep.frame().X_command_B;
      longest = std::max(longest, norm(now.p - last.p));
      last = now;
    }
    return lockstep.frame();
  }
  double speed_in_a_tick() {
    const Vec3 before = last.p;
    step();
    return norm(last.p - before) / 1e-3;
  }
};

}  // namespace

TEST_CASE("admittance: paused or disarmed the body brakes with the largest force", "[lab]") {
  const bool pauses = GENERATE(true, false);
  FreeRun run;
  run.step(100);
  const double before = run.speed_in_a_tick();
  CHECK(before > 0.3);
  (pauses ? run.lockstep.control().paused : run.lockstep.control().armed) = pauses ? 1 : 0;
  // m v / F, and no faster
  const double brake_time = kMass * before / kForce;
  run.step(static_cast<int>(1e3 * brake_time / 2));
  CHECK(run.speed_in_a_tick() == Approx(before / 2).epsilon(0.1));
  run.step(static_cast<int>(1e3 * brake_time / 2) + 5);
  const Vec3 at = run.last.p;
  run.step(200);
  CHECK(run.last.p == at);
  (pauses ? run.lockstep.control().paused : run.lockstep.control().armed) = pauses ? 0 : 1;
  run.step(50);
  CHECK(run.speed_in_a_tick() > 0.05);
  // never faster than the hand made it
  CHECK(run.longest < 1.1e-3 * std::max(before, 1.2));
}

TEST_CASE("admittance: with the clutch held the arm goes on and the tool stays", "[lab]") {
  FreeRun run;
  run.step(80);
  const Vec3 tool = run.lockstep.frame().X_WT.p;
  const Vec3 arm = run.last.p;
  run.arm.buttons = 1;
  run.step(40);
  CHECK(norm(run.last.p - arm) > 5e-3);
  CHECK(norm(run.lockstep.frame().X_WT.p - tool) < 2e-3);
  run.arm.buttons = 0;
  run.step(2);
  // the tool goes on from where it was, the arm without a jump
  CHECK(norm(run.lockstep.frame().X_WT.p - tool) < 4e-3);
  run.step(100);
  CHECK(run.lockstep.frame().fault == 0);
  CHECK(run.longest < 2e-3);
}

TEST_CASE("admittance: a lost device comes back without a jump, wherever it is", "[lab]") {
  FreeRun run;
  run.step(100);
  run.arm.is_lost = true;
  run.step(200);
  const Vec3 rest = run.last.p;
  run.step(50);
  CHECK(run.last.p == rest);
  run.arm.carry_to({{0.1, 0.05, 0.02}, {}});
  run.step(50);
  CHECK(run.last.p == rest);
  run.arm.is_lost = false;
  const ServoFrame& back = run.step();
  // it is sent where it is found
  CHECK(norm(back.X_command_B.p - back.device.X_BH.p) < 0.1e-3);
  run.longest = 0;
  run.step(5);
  CHECK(run.longest < 0.5e-3);
}

TEST_CASE("admittance: an arm that does not follow is a fault, and is asked to stay where it is",
          "[lab]") {
  FreeRun run;
  run.step(80);
  REQUIRE(run.speed_in_a_tick() > 0.3);
  run.arm.is_held = true;
  int ticks = 0;
  while (run.lockstep.frame().fault == 0 && ticks < 100) {
    run.step();
    ++ticks;
  }
  CAPTURE(ticks);
  CHECK(run.lockstep.frame().fault == static_cast<uint32_t>(Fault::kDeviceStale));
  CHECK(ticks > 53);
  CHECK(ticks < 65);
  run.step(10);
  CHECK(norm(run.last.p - run.lockstep.frame().device.X_BH.p) < 1e-9);
  // freed it does not jump, and with the fault cleared the hand moves it again
  run.arm.is_held = false;
  run.longest = 0;
  ++run.lockstep.control().fault_clears;
  run.step(5);
  CHECK(run.longest < 0.5e-3);
  run.step(100);
  CHECK(run.lockstep.frame().fault == 0);
  CHECK(run.speed_in_a_tick() > 0.1);
}

TEST_CASE("admittance: a soft body rests where the scene holds what the hand pushes with",
          "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kVoxel, Renderer::kDirect6);
  SessionConfig config = load_config(from_source("configs/six-peg.toml"));
  const SessionConfig arm_like = arm_session(renderer);
  config.renderer = renderer;
  // four pushes hold what this hand pushes with before a triangle of the peg has passed through
  config.proxy.contact_stiffness = 4000;
  config.safety = arm_like.safety;
  config.safety.max_force = 20;
  config.safety.max_torque = 1;
  config.device = arm_like.device;
  config.device.max_force = 20;
  config.device.max_torque = 1;
  config.device.admittance.mass = kMass;
  config.device.admittance.damping = 20;
  config.device.admittance.inertia = 4e-3;
  config.device.admittance.rotational_damping = 0.05;
  config.device.hand.hand_stiffness = 100;
  config.device.hand.hand_damping = 20;
  config.device.hand.hand_mass = 0.2;
  config.device.hand.hand_rotational_stiffness = 0.2;
  config.device.hand.hand_rotational_damping = 0.01;
  config.device.hand.hand_inertia = 1e-3;
  const BakedSession baked = bake_session(config);
  // beside the hole, down to 70 mm below where the peg comes to the board
  const auto down = [](double t) {
    Intent intent;
    intent.p_B = {0.02, 0, 0.08 - 0.1 * std::min(t, 1.0)};
    return intent;
  };
  SimulatedArm arm(config.device, down);
  Lockstep lockstep(config, baked.shapes(), arm);
  int touching = 0;
  for (int k = 0; k < 3200; ++k) {
    lockstep.step();
    touching += (lockstep.frame().flags & kServoContact) != 0;
  }
  const ServoFrame& f = lockstep.frame();
  CAPTURE(row_of(renderer).name, touching, f.F_device_B.f, f.F_coupling_W.f, f.device.X_BH.p,
          f.device.V_BH.v);
  CHECK(f.fault == 0);
  CHECK(touching > 800);
  CHECK(f.F_device_B.f.z > 1);
  // z of the device is y of the scene
  const Vec3 held_B = f.F_device_B.f;
  CHECK_THAT(f.F_coupling_W.f, IsNear({held_B.x, held_B.z, -held_B.y}, 0.1));
  CHECK(norm(f.device.V_BH.v) < 1e-3);
}
