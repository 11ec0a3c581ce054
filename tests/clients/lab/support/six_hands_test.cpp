// SPDX-License-Identifier: GPL-3.0-or-later
// Five hands hold an emulated device with six motors, through its bytes and on virtual time: the
// board's plant is judged, by the work of its own steps and by its motion.
#include <catch2/catch.hpp>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/sixmotors/kinematics.h"
#include "proto/math/units.h"
#include "tests/clients/lab/support/hand_energy.h"
#include "tests/support/data.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

using namespace test;

constexpr uint32_t kSixDoubt = kDeviceLost | kDeviceStale | kDeviceNoisy;

/// A session file, and what the hand means to do there.
struct SixScene {
  const char* file;
  Vec3 centre_B;  // as its first lines give it [m]
  Vec3 direction_B;
  double hover, press;  // [m]
  double angle, turn;   // [rad]
  Vec3 turn_axis_B;
};

const std::vector<SixScene> kScenes{
    {"six-peg", {1e-4, 0, 0}, {0, 0, 1}, 0.06, 0.01, 8 * kDegree, 4 * kDegree, {}},
    {"six-gears", {}, {1, 0, 0}, 0.072, 0.0585, 4 * kDegree, 3 * kDegree, {0, 1, 0}},
    {"six-rigid-peg", {2e-5, 0, 0}, {0, 0, 1}, 0.06, 0.01, 8 * kDegree, 2 * kDegree, {}}};

EmulatedDeviceOptions device_in(const HandImpedance& hand, const SixScene& scene) {
  EmulatedDeviceOptions options;
  options.arm = &six_motors_arm();
  options.hand.mass = 0.25;
  options.hand.damping = 0.5;
  options.hand.coulomb_friction = 0.2;
  options.hand.inertia = 1e-4;
  put_under(options.hand, hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {2e-5, 0, 0};
  intent.direction_B = scene.direction_B;
  intent.hover_radius = scene.hover;
  intent.press_radius = scene.press;
  intent.stroke_angle = scene.angle;
  intent.turn_angle = scene.turn;
  intent.turn_axis_B = scene.turn_axis_B;
  // the board is a second old when the session begins
  options.intention = [own = pausing(options.hand)](double t) { return own(t - 1); };
  return options;
}

/// The wrench of a record's currents at the pose that the server knew, less the commanded one.
Wrench missed(const EmulatorRecord& record, const Wrench& commanded_B) {
  MotorEfforts amperes;
  for (size_t i = 0; i < amperes.size(); ++i) amperes[i] = 1e-3 * record.currents[i];
  const Arm& arm = six_motors_arm();
  return arm.wrench(arm.angles(record.answered), amperes) + -commanded_B;
}

struct SixRun : Run {
  Wrench off;           // the largest, at the pose that the server knew [N], [N·m]
  double at_board = 0;  // the same at the board's own pose, over what is allowed
  size_t faults = 0, doubted = 0;
};

SixRun play_six(const SessionConfig& config, const ContactShapes& shapes,
                const EmulatedDeviceOptions& options, size_t ticks) {
  EmulatedArm device(options, config.device);
  Lockstep lockstep(config, shapes, device);
  SixRun run;
  Wrench commanded_B;
  double off = 0, off_torque = 0;
  for (size_t k = 0; k < ticks; ++k) {
    REQUIRE(lockstep.step());
    // the board has now obeyed the command of the tick before
    const EmulatorRecord& record = device.board().record();
    const Wrench miss = missed(record, commanded_B);
    off = std::max(off, norm(miss.f));
    off_torque = std::max(off_torque, norm(miss.t));
    // a tick later it is nearly the same: the arm turns by 0.5 m/s / 0.2 m in a millisecond
    run.at_board = std::max(
        {run.at_board, norm(record.force_B - commanded_B.f) / (2e-2 + 5e-3 * norm(commanded_B.f)),
         norm(record.torque_B - commanded_B.t) / (5e-4 + 5e-3 * norm(commanded_B.t))});
    commanded_B = lockstep.frame().F_device_B;
    run.note(config, options.hand, device.board().plant(), lockstep.frame());
    run.faults += (lockstep.frame().flags & kServoFault) != 0;
    run.doubted += (lockstep.frame().device.flags & kSixDoubt) != 0;
  }
  run.off = {{off, 0, 0}, {off_torque, 0, 0}};
  return run;
}

/// The session file as it is, with its damping and its soft start, in the hand that its first lines
/// give the emulator: what the motors are sent is what the servo commands.
void check_as_shipped(const SessionConfig& config, const ContactShapes& shapes,
                      const SixScene& scene) {
  EmulatedDeviceOptions options = device_in(*find_hand("typical"), scene);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = scene.centre_B;
  intent.stroke_time = 2;
  intent.tremor_amplitude = IntentConfig{}.tremor_amplitude;
  options.intention = {};
  // reach, and half of the first slide
  const SixRun run = play_six(config, shapes, options, 1000);
  CAPTURE(scene.file);
  CHECK(run.faults == 0);
  CHECK(run.doubted == 0);
  CHECK(run.at_board <= tol(1));
  // half a milliampere in each motor
  CHECK(norm(run.off.f) <= tol(5e-3));
  CHECK(norm(run.off.t) <= tol(2e-4));
  CHECK(run.force > 0.5);
  CHECK(run.torque > 0.01);
}

}  // namespace

TEST_CASE("six motors: five hands feel force and torque through the bytes, and gain nothing",
          "[lab]") {
  const SixScene scene = GENERATE(from_range(kScenes));
  SessionConfig config = load_config(from_source(std::string("configs/") + scene.file + ".toml"));
  const BakedSession baked = bake_session(config);
  check_as_shipped(config, baked.shapes(), scene);
  config.device.max_damping = config.device.max_rotational_damping = 0;
  config.safety.soft_start = 0;
  for (const HandImpedance& hand : played_hands()) {
    CAPTURE(scene.file, hand.name);
    const SixRun run = play_six(config, baked.shapes(), device_in(hand, scene), kTicks);
    CHECK(run.faults == 0);
    CHECK(run.doubted == 0);
    CHECK(run.at_board <= tol(1));
    // half a milliampere in each motor
    CHECK(norm(run.off.f) < 6e-3);
    CHECK(norm(run.off.t) < 2e-4);
    CHECK(largest_kinetic(run, 7) <= 0.01 * largest_kinetic(run, 0) + 1e-11);
    // a device that nobody holds stands in the middle, where a gear pushes it away
    if (hand.stiffness == 0) continue;
    CHECK(gained(run) <= 0);
    CHECK(run.touching > kTicks / 10);
    CHECK(run.force > 0.3);
    CHECK(run.torque > 3e-3);
  }
}

}  // namespace haptic
