// SPDX-License-Identifier: GPL-3.0-or-later
// Five hands hold an emulated Novint Falcon, through its bytes and its chip's millisecond, in whole
// sessions on virtual time: the emulator's plant is judged, by the work of its own steps and by its
// motion.
#include <catch2/catch.hpp>
#include <cmath>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "tests/clients/lab/support/hand_energy.h"
#include "tests/support/data.h"
#include "tests/support/driver/falcon_bench.h"

namespace haptic {
namespace {

using namespace test;

constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy | kDeviceLost;
constexpr size_t kFirstTicks = 50;  // until the firmware has answered, and a challenge is met

/// The shipped bunny under the shipped Falcon. Nothing but the coupling takes energy out.
SessionConfig bunny_under_falcon() {
  SessionConfig config = load_config(from_source("configs/bunny.toml"));
  const SessionConfig falcon = load_config(from_source("configs/falcon.toml"));
  config.device = falcon.device;
  config.coupling = falcon.coupling;
  config.safety = falcon.safety;
  config.safety.armed_at_start = 1;
  config.safety.soft_start = 0;
  config.device.max_damping = config.device.max_rotational_damping = 0;
  // its back lies in the middle of the workspace
  config.map.X_WB.p = {0, 0.02, 0};
  return config;
}

/// A hand that presses into the bunny's back, slides, stands still and lifts.
EmulatedFalconOptions falcon_in(const HandImpedance& hand) {
  EmulatedFalconOptions options;
  options.has_firmware = true;
  options.hand.mass = 0.25;
  options.hand.damping = 1;
  options.hand.coulomb_friction = 0.3;
  put_under(options.hand, hand);
  IntentConfig& intent = options.hand.intent;
  intent.centre_B = {0, -0.03, 0};
  intent.direction_B = {0, 1, 0};
  intent.hover_radius = 0.046;
  intent.press_radius = 0.01;
  intent.stroke_angle = 0.7;
  options.intention = pausing(options.hand);
  return options;
}

struct FalconRun : Run {
  size_t faults = 0, doubted = 0;
  double at_hand = 0;  // the largest force of the emulated motors [N]
};

FalconRun play_falcon(const SessionConfig& config, const ContactShapes& shapes,
                      const EmulatedFalconOptions& options) {
  FalconBench device(options, config.device);
  Lockstep lockstep(config, shapes, device);
  FalconRun run;
  for (size_t k = 0; k < kTicks; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& frame = lockstep.frame();
    run.note(config, options.hand, device.emulated().plant(), frame);
    run.at_hand = std::max(run.at_hand, norm(device.emulated().force_B()));
    if (k < kFirstTicks) continue;
    run.faults += (frame.flags & kServoFault) != 0;
    run.doubted += (frame.device.flags & kDoubt) != 0;
  }
  return run;
}

}  // namespace

TEST_CASE("falcon: five hands feel the bunny through its bytes, and gain nothing", "[lab]") {
  const SessionConfig config = bunny_under_falcon();
  REQUIRE(config.coupling.translational_stiffness == 500);
  const BakedSession baked = bake_session(config);
  for (const HandImpedance& hand : played_hands()) {
    const FalconRun run = play_falcon(config, baked.shapes(), falcon_in(hand));
    const double rest = largest_kinetic(run, 7), first = largest_kinetic(run, 0);
    CAPTURE(hand.name, run.faults, run.doubted, run.touching, run.at_hand, rest, first,
            gained(run));
    CHECK(run.faults == 0);
    CHECK(run.doubted == 0);
    CHECK(rest <= 0.01 * first + 1e-11);
    CHECK(gained(run) <= 0);
    CHECK(std::isfinite(run.accounts.back().given + run.accounts.back().stored));
    // a device that nobody holds stays in the middle
    if (hand.stiffness == 0) continue;
    CHECK(run.touching > kTicks / 10);
    CHECK(run.at_hand > 0.5);
  }
}

TEST_CASE("falcon: away for a second, it comes back without a step of force", "[lab]") {
  SessionConfig config = load_config(from_source("configs/falcon.toml"));
  config.safety.armed_at_start = 1;
  const BakedSession baked = bake_session(config);
  EmulatedFalconOptions options = falcon_in(*find_hand("typical"));
  options.intention = {};
  options.hand.intent.centre_B = {0, -0.008, 0};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = 0;
  FalconBench device(options, config.device);
  Lockstep lockstep(config, baked.shapes(), device);
  lockstep.control().armed = 1;
  const auto run = [&](int ticks) {
    double largest_step = 0;
    for (int k = 0; k < ticks; ++k) {
      const double before = norm(device.emulated().force_B());
      REQUIRE(lockstep.step());
      largest_step = std::max(largest_step, norm(device.emulated().force_B()) - before);
    }
    return largest_step;
  };
  const double first = run(1500);
  REQUIRE(norm(device.emulated().force_B()) > 1);
  device.emulated().lie(Lie::kSilent);
  run(1000);
  CHECK(norm(device.emulated().force_B()) == 0);
  CHECK((lockstep.frame().flags & kServoNoDevice) != 0);
  device.emulated().lie(Lie::kHealthy);
  const double step = run(2000);
  CAPTURE(step, first);
  // not one of 4 N, which is what the spring of this depth would push with; as gentle as the first
  // time, when the passivity controller's damper came and went at the hand's 40 mm/s as well
  CHECK(step < 0.25);
  CHECK(step <= 1.1 * first);
  CHECK(norm(device.emulated().force_B()) > 1);
}

}  // namespace haptic
