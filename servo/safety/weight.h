// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/safety/safety.h"

namespace haptic {

/// The way of a handle since it stood still.
struct Departure {
  Vec3 rest_B;       // where it stands, or has last moved to
  double still = 0;  // for so long it has stood there [s]
  bool has_left = false;
  Vec3 from_B;      // where it stood before it left
  double left = 0;  // since then [s]
};

struct WeightState {
  double gain = 0;     // of the fade, 0 to 1
  bool ended = false;  // the handle ran away, and no hand has come since
  Departure departure;
};

struct WeightInput {
  Wrench holding_B;       // that holds up arm and handle, by the device's table; may be no number
  Wrench F_safe_B;        // of everything else, after safety
  DeviceState device{};   // this tick's sample, finite
  uint32_t flags = 0;     // ServoFlag of this tick
  bool released = false;  // the device may have been set to zero since the last tick
  MotorHeat heat;         // of the motors, before this tick
};

struct WeightOutput {
  Wrench F_B;  // that the device is told
  uint32_t flags = 0;
  MotorHeat heat;  // after it
};

/// The wrench that holds up the arm's own weight, added to what the hand feels. It comes after
/// safety and is no part of its slew, its passivity or the counters of what pushes: a weight that
/// is held up neither gives energy to the hand nor touches an object.
///
///   inputs  holding_B, what safety lets through, the flags of the tick, the handle's place
///   gain    rises over 1 s while nothing closes the force; falls over 1 s in a pause, while
///           disarmed and while the handle is too fast; zero at once by a fault, without a device,
///           after the device was let go of, and where holding_B is no number
///   F       F_safe + s · gain · holding, s ≤ 1 the largest with |F| ≤ what the motors can sustain:
///           what the hand feels comes first; force and torque each for itself
///   heat    of F, so that safety's thermal budget counts the weight too
///   guard   a table that is wrong in sign or far too heavy throws a bare arm. Without a hand is
///           one whose handle has stood within 0.1 mm for 0.2 s, has no button down, and from there
///           goes 20 mm within 0.2 s, as if a quarter of gravity or more drew it (0.3 m/s), within
///           60° of this force and with less help of any other. The gain is then zero until the
///           force is closed, or a hand has come: the handle stands so again, and is taken 10 mm
///           from there. A hand may start as an arm is thrown; it misses this force until it rests
///   bound   20 mm, or 0.2 s from standing still, after which the arm is as without a table
WeightOutput hold_weight(const SafetyLimits& limits, WeightState& state, const WeightInput& input,
                         double dt);

}  // namespace haptic
