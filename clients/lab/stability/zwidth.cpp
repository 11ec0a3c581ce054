// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/zwidth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "device-io/hand/intended_motion.h"

namespace haptic {
namespace {

constexpr double kRise = 0.4;      // the press grows this long [s]
constexpr double kKnockAt = 0.5;   // [s]
constexpr double kKnock = 0.2;     // amplitude of the knock, of the rest depth
constexpr double kKnockSteps = 5;  // and at least so many steps of the encoder

constexpr double kWithin = 1.005;  // ratio of the bounds at which the bisection ends
constexpr double kFirst = 0.2;     // of Gil's limit, where it begins
constexpr double kMost = 1e4;      // times Gil's limit: no further
constexpr double kLeast = 1e-4;    // of Gil's limit: nothing below it is stable

/// Smallest and largest of the values so far.
struct Swing {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double x) { low = std::min(low, x), high = std::max(high, x); }
  double size() const { return high > low ? high - low : 0; }
};

/// The stiffness of the coupling and the hand together.
double whole_stiffness(const ProbeSetting& setting) {
  return setting.stiffness + probed_body(setting).hand_stiffness;
}

/// The impulse that makes a mass swing by that amplitude, over one tick.
double knock(const ProbeSetting& setting, double amplitude) {
  const double speed = amplitude * std::sqrt(whole_stiffness(setting) / probed_body(setting).mass);
  return probed_body(setting).mass * speed * setting.rate;
}

Wrench along_axis(bool turning, double size) {
  return turning ? Wrench{{}, {0, size, 0}} : Wrench{{0, 0, size}, {}};
}

}  // namespace

Ringing ring(const ProbeScene& scene, const ProbeSetting& setting) {
  const SessionConfig config = scene.session(setting);
  const bool turning = scene.turning();
  Ringing out;
  out.step = turning ? setting.hand.angle_step : setting.hand.encoder_step;
  out.rest = linear_limit(turning) / whole_stiffness(setting);
  // the hand means to stay where it is
  PushedHand hand(
      config.device, [](double) { return Intent{}; }, setting.delay);
  Lockstep lockstep(config, scene.shapes(), hand, {1, 0});

  const auto tick_at = [&](double seconds) { return std::llround(seconds * setting.rate); };
  const int64_t knock_at = tick_at(kKnockAt), end = tick_at(kKnockAt + kRinging);
  Swing early, late;
  for (int64_t tick = 0; tick < end; ++tick) {
    const double t = static_cast<double>(tick) / setting.rate;
    hand.push_B = {{0, 0, -kPress * minimum_jerk(std::min(t / kRise, 1.0), 1).s}, {}};
    if (tick == knock_at) {
      hand.push_B =
          hand.push_B +
          along_axis(turning, knock(setting, std::max(kKnock * out.rest, kKnockSteps * out.step)));
    }
    lockstep.step();
    const HandPlant& plant = hand.plant();
    const double place = turning ? to_rotation_vector(plant.q_B).y : plant.p_B.z;
    if (tick >= knock_at + tick_at(1) && tick < knock_at + tick_at(2)) early.include(place);
    if (tick >= end - tick_at(1)) late.include(place);
  }
  out.early = early.size();
  out.late = late.size();
  return out;
}

bool dies_out(const Ringing& r) {
  constexpr double kSteps = 3, kFelt = 0.1, kQuiet = 1e-3, kSteadier = 0.9;
  if (!(r.late <= r.rest)) return false;
  const double quiet = r.step > 0 ? std::min(kSteps * r.step, kFelt * r.rest) : kQuiet * r.rest;
  if (r.late <= quiet) return true;
  return r.late < (r.step > 0 ? kSteadier : 1) * r.early;
}

LargestStiffness largest_stiffness(const ProbeScene& scene, ProbeSetting setting) {
  const auto holds = [&](double stiffness) {
    setting.stiffness = stiffness;
    return dies_out(ring(scene, setting));
  };
  const double scale = std::max(gil_limit(setting), 1e-6);
  double low = kFirst * scale;
  while (!holds(low)) {
    low /= 4;
    if (low < kLeast * scale) return {};
  }
  double high = 2 * low;
  while (holds(high)) {
    low = high;
    high *= 2;
    if (high > kMost * scale) return {low, true};
  }
  while (high > kWithin * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return {low, false};
}

double gil_limit(const ProbeSetting& setting) {
  const double T = 1 / setting.rate;
  return (probed_body(setting).damping + setting.damping) / (T * (0.5 + setting.delay));
}

double abbott_okamura_limit(const ProbeSetting& setting) {
  const SimulatedHandConfig& hand = setting.hand;
  const double damping = setting.turning ? hand.rotational_damping : hand.damping;
  const double friction = setting.turning ? hand.rotational_friction : hand.coulomb_friction;
  const double step = setting.turning ? hand.angle_step : hand.encoder_step;
  const double by_damping = 2 * damping * setting.rate;
  return step > 0 ? std::min(by_damping, 2 * friction / step) : by_damping;
}

}  // namespace haptic
