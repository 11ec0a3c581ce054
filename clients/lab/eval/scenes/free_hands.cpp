// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "clients/lab/eval/scenes/free_scenes.h"
#include "clients/lab/support/dice.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kFast = 2, kTurn = 10;  // [m/s], [rad/s]
constexpr double kFarAway = 0.5;         // [m]

/// To and fro along a unit vector, never faster than `speed`.
FreeHand sweep(std::string name, const Vec3& middle, const Vec3& along, double way, double speed,
               const Vec3& turn) {
  return {std::move(name), [=](double t) {
            return Pose{middle + way * std::sin(speed / way * t) * along,
                        from_rotation_vector(t * turn)};
          }};
}

/// Sums of sines in all six directions, as fast as the fastest hands.
FreeHand shaken(const Vec3& middle, Dice& dice) {
  struct Sine {
    Vec3 along;
    double rate, phase;
  };
  constexpr size_t kSines = 4;
  std::array<Sine, kSines> ways{}, turns{};
  for (std::array<Sine, kSines>* sines : {&ways, &turns}) {
    for (Sine& s : *sines) {
      s.along = dice.direction();
      s.rate = dice.uniform(10, 60), s.phase = dice.uniform(0, 2 * kPi);
    }
  }
  const auto sum = [](const std::array<Sine, kSines>& sines, double speed, double t) {
    Vec3 out;
    for (const Sine& s : sines) {
      out += speed / (kSines * s.rate) * std::sin(s.rate * t + s.phase) * s.along;
    }
    return out;
  };
  return {"shaken", [=](double t) {
            return Pose{middle + sum(ways, kFast, t), from_rotation_vector(sum(turns, kTurn, t))};
          }};
}

/// Down to a place and up again with minimum jerk.
FreeHand reach(const Vec3& end, double way, double speed) {
  const double duration = 15.0 / 8 * way / speed;  // of one way
  return {"reach", [=](double t) {
            const double s = 1 - std::fabs(1 - std::min(t / duration, 2.0));
            const double share = s * s * s * (10 - 15 * s + 6 * s * s);
            return Pose{end + Vec3{0, 0, (1 - share) * way}, {}};
          }};
}

/// Down at constant speed to `deep` below the touch, and up again at the same speed, turning.
FreeHand slap(const Vec3& touch, double height, double deep, double speed) {
  const double down = (height + deep) / speed;  // [s]
  return {"slap", [=](double t) {
            const double z = t < down ? height - speed * t : speed * (t - down) - deep;
            const double up = std::max(t - 1.2 * down, 0.0);
            return Pose{touch + Vec3{0, 0, std::min(z, 0.2)},
                        from_rotation_vector({0.5 * kTurn * up, 0, 0.2 * kTurn * up})};
          }};
}

FreeHand tremor(const Vec3& middle) {
  return {"tremor", [=](double t) {
            const double phase = 2 * kPi * 10 * t;
            const Vec3 way{std::sin(phase), std::sin(1.1 * phase + 1), std::sin(0.9 * phase + 2)};
            return Pose{middle + 0.5 * kMm * way, from_rotation_vector(0.02 * way)};
          }};
}

FreeHand creep(const Vec3& start, double speed) {
  return {"creep", [=](double t) { return Pose{start + Vec3{speed * t, 0, -speed * t}, {}}; }};
}

}  // namespace

std::vector<FreeHand> free_hands(const Vec3& touch, uint64_t seed) {
  Dice dice(seed);
  const Vec3 far = touch + Vec3{0, 0, kFarAway};
  const Vec3 axis = dice.direction(), way = dice.direction();
  return {
      sweep("sweep of 0.8 m/s", far, {1, 0, 0}, 0.1, 0.8, {}),
      sweep("sweep of 2 m/s", far, way, 0.1, kFast, {}),
      sweep("turn of 10 rad/s", far, way, 0.01, 0.1, kTurn * axis),
      sweep("sweep and turn", far, way, 0.1, kFast, kTurn * axis),
      shaken(far, dice),
      reach(touch + Vec3{0, 0, 15 * kMm}, 0.15, kFast),
      slap(touch, 60 * kMm, 3 * kMm, 1.5),
      sweep("stroke", touch + Vec3{0, 0, 60 * kMm}, {1, 0, 0}, 0.15, 1.2, 5 * axis),
      sweep("stroke and turn", touch + Vec3{0, 0, 80 * kMm}, {1, 0, 0}, 0.15, kFast, kTurn * axis),
      tremor(touch + Vec3{0, 0, 25 * kMm}),
      creep(touch + Vec3{0, 0, 10 * kMm}, 5 * kMm)};
}

}  // namespace haptic
