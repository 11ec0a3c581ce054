// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions with force and torque through the bytes of an emulated device with six motors, on
// virtual time: what the servo says it commands is what the motors are sent.
#include <cmath>

#include "clients/lab/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/hand/impedance.h"
#include "device-io/sixmotors/six_motors.h"
#include "tests/support/data.h"
#include "tests/support/emulated_arm.h"
#include "tests/support/near.h"

namespace haptic {
namespace {

/// A session file and the hand that its first lines give the emulator.
struct Scene {
  const char* config;
  IntentConfig intent;
};

IntentConfig intent_of(const Vec3& centre_B, const Vec3& direction_B, double hover, double press,
                       double angle, double turn, const Vec3& turn_axis_B) {
  IntentConfig intent;
  intent.centre_B = centre_B;
  intent.direction_B = direction_B;
  intent.hover_radius = hover;
  intent.press_radius = press;
  intent.stroke_angle = angle;
  intent.stroke_time = 2;
  intent.turn_angle = turn;
  intent.turn_axis_B = turn_axis_B;
  return intent;
}

constexpr double kDegree = 0.0174532925199433;

std::vector<Scene> scenes() {
  return {{"configs/six-peg.toml",
           intent_of({1e-4, 0, 0}, {0, 0, 1}, 0.06, 0.01, 8 * kDegree, 4 * kDegree, {})},
          {"configs/six-gears.toml",
           intent_of({}, {1, 0, 0}, 0.072, 0.0585, 4 * kDegree, 3 * kDegree, {0, 1, 0})},
          {"configs/six-rigid-peg.toml",
           intent_of({2e-5, 0, 0}, {0, 0, 1}, 0.06, 0.01, 8 * kDegree, 2 * kDegree, {})}};
}

EmulatedDeviceOptions device_in_hand(const IntentConfig& intent) {
  EmulatedDeviceOptions options;
  options.arm = &six_motors_arm();
  options.hand.mass = 0.25;
  options.hand.damping = 0.5;
  options.hand.coulomb_friction = 0.2;
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand("typical"), options.hand);
  options.hand.intent = intent;
  return options;
}

/// The wrench of the currents in the emulator's log at the pose that the server knew.
Wrench sent(const EmulatorRecord& record) {
  MotorAmperes amperes;
  for (size_t i = 0; i < amperes.size(); ++i) amperes[i] = 1e-3 * record.currents[i];
  const Arm& arm = six_motors_arm();
  return arm.wrench(arm.angles(record.answered), amperes);
}

}  // namespace

TEST_CASE("six motors: force and torque at the motors are those that the servo commands", "[lab]") {
  const size_t number = GENERATE(range(size_t{0}, size_t{3}));
  const Scene scene = scenes()[number];
  CAPTURE(scene.config);
  const SessionConfig config = load_config(test::from_source(scene.config));
  BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  test::EmulatedArm<SixMotors> device(device_in_hand(scene.intent), config.device);
  Lockstep lockstep(config, shapes, device);
  Wrench commanded_B;
  double strongest = 0, most_torque = 0, off = 0, off_torque = 0;
  // reach, and half of the first slide
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(lockstep.step());
    const EmulatorRecord& record = device.board().record();
    // the board has now obeyed the command of the tick before
    const Wrench sent_B = sent(record);
    off = std::max(off, norm(sent_B.f - commanded_B.f));
    off_torque = std::max(off_torque, norm(sent_B.t - commanded_B.t));
    strongest = std::max(strongest, norm(record.force_B));
    most_torque = std::max(most_torque, norm(record.torque_B));
    // at the board's own pose, a tick later, it is nearly the same: the arm turns by 0.5 m/s / 0.2
    // m in a millisecond
    REQUIRE(norm(record.force_B - commanded_B.f) <= test::tol(2e-2 + 5e-3 * norm(commanded_B.f)));
    REQUIRE(norm(record.torque_B - commanded_B.t) <= test::tol(5e-4 + 5e-3 * norm(commanded_B.t)));
    const ServoFrame& f = lockstep.frame();
    REQUIRE((f.flags & kServoFault) == 0);
    REQUIRE((f.device.flags & (kDeviceLost | kDeviceStale | kDeviceNoisy)) == 0);
    commanded_B = f.F_device_B;
  }
  // half a milliampere in each motor
  CHECK(off <= test::tol(5e-3));
  CHECK(off_torque <= test::tol(2e-4));
  CHECK(strongest > 0.5);
  CHECK(most_torque > 0.01);
  WARN(scene.config << ": " << strongest << " N, " << most_torque << " N·m; off by " << off
                    << " N, " << off_torque << " N·m");
}

}  // namespace haptic
