// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/intent.h"

#include <cmath>

#include "device-io/hand/portable_turn.h"
#include "device-io/hand/waypoints.h"
#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kReachShare = 0.25;                 // of stroke_time, for reach and for lift each
constexpr double kTravelShare = 0.5;                 // of stroke_time, in addition to it
constexpr double kCycleShare = 1 + kTravelShare;     // period of a cycle over stroke_time
constexpr double kTremorLow = 8, kTremorHigh = 12;   // [Hz]
constexpr uint64_t kTremorStream = ~uint64_t{0};     // number of no stroke
constexpr uint64_t kTurnStream = uint64_t{1} << 63;  // added to a stroke's number, for its turn

/// splitmix64 (Steele, Lea, Flood 2014): a stream of 64-bit hashes.
struct SplitMix {
  uint64_t state;
  uint64_t next() {
    uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  // uniform in [0, 1), 53 bits
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
};

SplitMix stream_of(uint64_t seed, uint64_t number) {
  return {SplitMix{seed}.next() ^ SplitMix{number}.next()};
}

/// Draws a direction by rejection from the cube, without transcendental functions.
Vec3 random_direction(SplitMix& random) {
  for (;;) {
    const Vec3 a{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
    const double length_squared = norm_squared(a);
    if (length_squared > 0.01 && length_squared <= 1) return normalized(a);
  }
}

/// Unit directions at both ends of a stroke, and across the first, in the plane of the arc.
struct Stroke {
  Vec3 from, across, to;
};

Stroke stroke_at(const IntentConfig& config, uint64_t seed, uint64_t number) {
  SplitMix random = stream_of(seed, number);
  Stroke stroke;
  stroke.from = random_direction(random);
  if (config.direction_B != Vec3{}) stroke.from = config.direction_B;
  // a second random direction, made perpendicular, is uniform on the circle around the first
  const Vec3 other = random_direction(random);
  const Vec3 rest = other - dot(other, stroke.from) * stroke.from;
  stroke.across = norm_squared(rest) > 1e-6 ? normalized(rest) : any_perpendicular(stroke.from);
  stroke.to = portable_cos(config.stroke_angle) * stroke.from +
              portable_sin(config.stroke_angle) * stroke.across;
  return stroke;
}

/// A point on the circle from `from` through `across`, about the origin.
Intent on_arc(const Vec3& from, const Vec3& across, double radius, double angle, double rate) {
  const double c = portable_cos(angle), s = portable_sin(angle);
  return {radius * (c * from + s * across), radius * rate * (c * across - s * from)};
}

/// Along the shorter great-circle arc; for half a turn any plane will do.
Intent travel(const Vec3& from, const Vec3& to, double radius, const IntentProgress& progress) {
  const Vec3 rest = to - dot(to, from) * from;
  const double sine = norm(rest);
  const Vec3 across = sine > 1e-9 ? rest / sine : any_perpendicular(from);
  // half the angle from its sine and cosine, by Newton's method on the portable sine
  const double half_sine = norm(to - from) / 2, half_cosine = norm(to + from) / 2;
  double half = half_sine < half_cosine ? half_sine : kPi / 2 - half_cosine;
  for (int i = 0; i < 4; ++i) {
    half += half_sine * portable_cos(half) - half_cosine * portable_sin(half);
  }
  return on_arc(from, across, radius, 2 * half * progress.s, 2 * half * progress.rate);
}

Intent stroke_motion(const IntentConfig& config, uint64_t seed, double t) {
  const IntentPhase phase = intent_phase(config, t);
  const IntentProgress progress = minimum_jerk(phase.fraction, phase.duration);
  const Stroke stroke = stroke_at(config, seed, phase.stroke);
  const double depth = config.hover_radius - config.press_radius;
  switch (phase.part) {
    case IntentPart::kReach:
      return {(config.hover_radius - depth * progress.s) * stroke.from,
              -depth * progress.rate * stroke.from};
    case IntentPart::kSlide:
      return on_arc(stroke.from, stroke.across, config.press_radius,
                    config.stroke_angle * progress.s, config.stroke_angle * progress.rate);
    case IntentPart::kLift:
      return {(config.press_radius + depth * progress.s) * stroke.to,
              depth * progress.rate * stroke.to};
    case IntentPart::kTravel:
      break;
  }
  const Stroke next = stroke_at(config, seed, phase.stroke + 1);
  return travel(stroke.to, next.from, config.hover_radius, progress);
}

Intent tremor(double amplitude, uint64_t seed, double t) {
  SplitMix random = stream_of(seed, kTremorStream);
  Intent out;
  for (int axis = 0; axis < 3; ++axis) {
    const double speed = 2 * kPi * (kTremorLow + (kTremorHigh - kTremorLow) * random.uniform());
    const double angle = speed * t + 2 * kPi * random.uniform();
    out.p_B[axis] = amplitude / std::sqrt(3.0) * portable_sin(angle);
    out.v_B[axis] = amplitude / std::sqrt(3.0) * speed * portable_cos(angle);
  }
  return out;
}

/// Rotation vector of the whole turn of a stroke [rad].
Vec3 turn_at(const IntentConfig& config, uint64_t seed, uint64_t number) {
  SplitMix random = stream_of(seed, number + kTurnStream);
  if (config.turn_axis_B == Vec3{}) return config.turn_angle * random_direction(random);
  return (random.uniform() < 0.5 ? -config.turn_angle : config.turn_angle) * config.turn_axis_B;
}

/// Orientation and angular velocity at t.
void put_turn(const IntentConfig& config, uint64_t seed, double t, Intent& intent) {
  const IntentPhase phase = intent_phase(config, t);
  if (phase.part == IntentPart::kReach) return;
  const IntentProgress progress = minimum_jerk(phase.fraction, phase.duration);
  const Vec3 turn = turn_at(config, seed, phase.stroke);
  // about one axis: the angular velocity is the derivative of the rotation vector
  double share = 1;
  if (phase.part == IntentPart::kSlide) {
    share = progress.s;
    intent.w_B = progress.rate * turn;
  } else if (phase.part == IntentPart::kTravel) {
    share = 1 - progress.s;
    intent.w_B = -progress.rate * turn;
  }
  intent.q_B = portable_turn(share * turn);
}

}  // namespace

IntentPhase intent_phase(const IntentConfig& config, double t) {
  HAPTIC_ASSERT(config.stroke_time > 0);
  const double strokes = std::fmax(t, 0) / config.stroke_time;
  const double cycles = std::floor(strokes / kCycleShare);
  const double share = std::fmax(strokes - cycles * kCycleShare, 0);
  constexpr struct {
    IntentPart part;
    double start, end;
  } kParts[] = {{IntentPart::kReach, 0, kReachShare},
                {IntentPart::kSlide, kReachShare, 1 - kReachShare},
                {IntentPart::kLift, 1 - kReachShare, 1},
                {IntentPart::kTravel, 1, kCycleShare}};
  int i = 0;
  while (i < 3 && share >= kParts[i].end) ++i;
  const double length = kParts[i].end - kParts[i].start;
  const double fraction = std::fmin((share - kParts[i].start) / length, 1);
  return {static_cast<uint64_t>(cycles), kParts[i].part, fraction, length * config.stroke_time};
}

Intent intent_at(const IntentConfig& config, uint64_t seed, double t) {
  const double elapsed = std::fmax(t, 0);
  const Intent shake = tremor(config.tremor_amplitude, seed, elapsed);
  if (config.n_waypoints > 0) {
    Intent way = along_waypoints(config, elapsed);
    way.p_B += shake.p_B;
    way.v_B = t < 0 ? Vec3{} : way.v_B + shake.v_B;
    return way;
  }
  const Intent stroke = stroke_motion(config, seed, elapsed);
  Intent intent;
  intent.p_B = config.centre_B + stroke.p_B + shake.p_B;
  intent.v_B = t < 0 ? Vec3{} : stroke.v_B + shake.v_B;
  if (config.turn_angle != 0) put_turn(config, seed, elapsed, intent);
  return intent;
}

}  // namespace haptic
