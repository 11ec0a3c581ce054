// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/weight.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kFade = 1;           // of the gain, from 0 to 1 or back [s]
constexpr double kStanding = 0.1e-3;  // half the width of a hand's tremor [m]
constexpr double kStood = 0.2;        // two turns of a tremor of 8 to 12 Hz [s]
constexpr double kRunaway = 20e-3;    // [m]; an arm thrown by its own weight takes 60 ms
constexpr double kWithin = 0.2;       // [s]
constexpr double kThrown = 0.3;       // there: by a quarter of gravity; half of most strokes [m/s]
constexpr double kTaken = 10e-3;      // by a hand, from where the arm came to rest [m]
constexpr double kAlong = 0.5;        // cosine of a way that the force has led

constexpr uint32_t kEndsAtOnce = kServoFault | kServoNoDevice;
constexpr uint32_t kFades = kServoPaused | kServoDisarmed | kServoTooFast;

void follow(Departure& own, const Vec3& p_B, double dt) {
  own.still += dt;
  own.left += dt;
  if (norm(p_B - own.rest_B) <= kStanding) return;
  if (own.still > kStood) {
    own.from_B = own.rest_B;
    own.left = 0;
    own.has_left = true;
  }
  own.rest_B = p_B;
  own.still = 0;
}

/// True if the handle ran away from standing still, along a force that `other_B` helps less.
bool ran_away(const Departure& own, const DeviceState& device, const Vec3& push_B,
              const Vec3& other_B) {
  if (!own.has_left || own.left > kWithin || device.buttons != 0) return false;
  const Vec3 way_B = device.X_BH.p - own.from_B;
  const double work = dot(push_B, way_B);
  return norm(way_B) >= kRunaway && norm(device.V_BH.v) >= kThrown &&
         work > kAlong * norm(push_B) * norm(way_B) && work > dot(other_B, way_B);
}

/// The part of `own` that may be added to what is felt within the limit.
Vec3 within(const Vec3& felt, const Vec3& own, double limit, bool& cut) {
  const double squared = norm_squared(own);
  if (squared == 0) return own;
  // |felt + s own| = limit, for the larger s
  const double half = dot(felt, own);
  const double left = std::max(limit * limit - norm_squared(felt), 0.0);
  const double share = (std::sqrt(half * half + squared * left) - half) / squared;
  cut |= share < 1;
  return std::min(share, 1.0) * own;
}

void follow_gain(WeightState& state, const WeightInput& input, double dt) {
  if ((input.flags & kEndsAtOnce) != 0 || input.released || !is_finite(input.holding_B)) {
    state.gain = 0;
  } else {
    state.gain += ((input.flags & kFades) != 0 ? -dt : dt) / kFade;
  }
  if ((input.flags & (kEndsAtOnce | kFades)) != 0) state.ended = false;
  // nothing but a hand moves an arm that has come to rest
  const Departure& departure = state.departure;
  const double way = norm(input.device.X_BH.p - departure.from_B);
  if (departure.has_left && way >= kTaken) state.ended = false;
  state.gain = state.ended ? 0 : std::clamp(state.gain, 0.0, 1.0);
}

}  // namespace

WeightOutput hold_weight(const SafetyLimits& limits, WeightState& state, const WeightInput& input,
                         double dt) {
  HAPTIC_ASSERT(dt > 0 && is_finite(input.F_safe_B) && is_finite(input.device.X_BH));
  WeightOutput out{input.F_safe_B, 0, {}};
  follow(state.departure, input.device.X_BH.p, dt);
  follow_gain(state, input, dt);
  Wrench own_B = state.gain > 0 ? state.gain * input.holding_B : Wrench{};
  if (limits.max_torque <= 0) own_B.t = {};
  if (ran_away(state.departure, input.device, own_B.f, input.F_safe_B.f)) {
    state.ended = true;
    state.departure.has_left = false;
    state.gain = 0;
    own_B = {};
  }
  if (state.ended) out.flags |= kServoWeightEnded;
  if (own_B != Wrench{}) {
    const WrenchLimit most = bearable(limits, input.heat);
    bool cut = false;
    out.F_B.f += within(input.F_safe_B.f, own_B.f, most.force, cut);
    out.F_B.t += within(input.F_safe_B.t, own_B.t, most.torque, cut);
    if (cut) out.flags |= kServoSaturated;
    // rounding must not exceed a limit
    saturate(out.F_B, most);
  }
  out.heat = heated(input.heat, out.F_B, dt);
  return out;
}

}  // namespace haptic
