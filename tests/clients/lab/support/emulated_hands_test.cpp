// SPDX-License-Identifier: GPL-3.0-or-later
// Five hands on an emulated WoodenHaptics, whole sessions on virtual time: an honest device is
// never taken for a lying one.
#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/hand/impedance.h"
#include "tests/support/data.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy | kDeviceLost;

/// The emulator's arm with this hand, which strokes and presses with a tremor.
EmulatedDeviceOptions arm_in(const HandImpedance& hand) {
  EmulatedDeviceOptions options;
  options.hand.mass = 0.15;
  options.hand.damping = 0.3;
  options.hand.coulomb_friction = 0.2;
  put_into_hand(hand, options.hand);
  options.hand.intent.centre_B = {};
  return options;
}

}  // namespace

TEST_CASE("emulated hands: five of them touch a block, and none is taken for a fault", "[lab]") {
  const HandImpedance hand = GENERATE(from_range(kHandImpedances));
  CAPTURE(hand.name);
  SessionConfig config = load_config(test::from_source("configs/woodenhaptics.toml"));
  config.safety.armed_at_start = 1;
  BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  test::EmulatedArm device(arm_in(hand));
  Lockstep lockstep(config, shapes, device);
  // an hour each is 3,600,000 ticks: HAPTIC_TORTURE_SCALE=1200
  const auto ticks = static_cast<uint64_t>(test::sweep(3000));
  uint64_t touching = 0, faults = 0, doubted = 0, held = 0;
  for (uint64_t i = 0; i < ticks; ++i) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    touching += (f.flags & kServoContact) != 0;
    faults += (f.flags & kServoFault) != 0;
    doubted += (f.device.flags & kDoubt) != 0;
    held += (f.device.flags & kDeviceHeld) != 0;
  }
  CHECK(faults == 0);
  CHECK(doubted == 0);
  // except in the first tick, before anything has been requested
  CHECK(held == 1);
  if (hand.stiffness > 0) CHECK(touching > ticks / 20);
  WARN(hand.name << ": " << ticks << " ticks, " << touching << " in contact, " << faults
                 << " in fault, " << doubted << " doubted");
}

}  // namespace haptic
