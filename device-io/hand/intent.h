// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/hand/intended_motion.h"
#include "proto/config/config.h"

namespace haptic {

/// The parts of a cycle, in order; each starts and ends at rest.
enum class IntentPart { kReach, kSlide, kLift, kTravel };

/// Phase of the intended motion. Reach, slide and lift divide stroke_time 1:2:1; travel to the
/// start of the next stroke takes another half of it.
struct IntentPhase {
  uint64_t stroke;  // counted from zero
  IntentPart part;
  double fraction;  // of the part, [0, 1]
  double duration;  // of the part [s]
};

IntentPhase intent_phase(const IntentConfig& config, double t);

/// The intended motion t seconds after the start; for t < 0 its initial position at rest. With the
/// minimum-jerk progress s = 10τ³ − 15τ⁴ + 6τ⁵ (Flash & Hogan 1985) of each part, stroke k
///   - reaches along a direction u1, from hover_radius to press_radius;
///   - slides along the arc of that radius to u2, which is u1 turned by stroke_angle;
///   - lifts to hover_radius along u2;
///   - travels on the sphere of hover_radius, by the shorter arc, to the u1 of stroke k + 1.
/// The directions are a hash of (seed, k), uniform on the sphere; u1 is direction_B if the config
/// gives one (with stroke_angle zero the hand then presses on one spot). A tremor of 8 to 12 Hz per
/// axis is added, at most tremor_amplitude long.
/// The handle is at the identity while it reaches, turns by turn_angle while it slides (about
/// turn_axis_B, to either side by the hash, or about a random axis), stays so while it lifts, and
/// turns back while it travels, by the same progress s. With waypoints there are no strokes: it
/// goes along them (waypoints.h), with the tremor. A pure function of time, C¹, made of exactly
/// rounded operations only, so bit-identical on every machine.
Intent intent_at(const IntentConfig& config, uint64_t seed, double t);

}  // namespace haptic
