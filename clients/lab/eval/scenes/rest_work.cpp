// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/rest_work.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "clients/lab/eval/scenes/scan_work.h"
#include "clients/lab/support/dice.h"
#include "clients/lab/support/soups.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// The path of a hand from place to place, one position per tick.
class Way {
 public:
  Way(const Vec3& start, uint64_t ticks) : ticks_(ticks), at_{start} {}
  bool ends() const { return at_.size() >= ticks_; }

  /// Straight at that mean speed [m/s], with minimum jerk (Flash & Hogan 1985) or at constant
  /// speed.
  void reach(const Vec3& to, double speed, bool is_smooth = true) {
    const Vec3 from = at_.back();
    const double n = std::ceil(std::max(norm(to - from) / speed / kTick, 1.0));
    for (double k = 1; k <= n; ++k) {
      const double s = k / n, share = is_smooth ? s * s * s * (10 + s * (6 * s - 15)) : s;
      at_.push_back(from + share * (to - from));
    }
  }
  void run(const Vec3& to, double speed) { reach(to, speed, false); }
  void stay(double seconds) {
    at_.resize(at_.size() + static_cast<size_t>(seconds / kTick), at_.back());
  }
  const std::vector<Vec3>& positions() const { return at_; }

 private:
  uint64_t ticks_;
  std::vector<Vec3> at_;
};

/// Approaches the sphere of `radius` from outside and then wanders on it at `speed`.
void follow_surface(Way& way, Dice& dice, double radius, double speed) {
  Vec3 u = normalized(way.positions().back());
  way.reach(radius * u, 0.1);
  while (!way.ends()) {
    u = normalized(u + 0.3 * dice.direction());
    way.run(radius * u, speed);
  }
}

std::vector<Vec3> tremble(std::vector<Vec3> positions, Dice& dice) {
  constexpr double kAmplitude = 1e-3, kRate = 2 * std::numbers::pi * 10;  // [m], [rad/s]
  const Vec3 a = dice.direction(), b = dice.direction();
  for (size_t k = 0; k < positions.size(); ++k) {
    const double angle = kRate * kTick * static_cast<double>(k);
    positions[k] += kAmplitude * (std::sin(angle) * a + std::cos(1.13 * angle) * b);
  }
  return positions;
}

}  // namespace

std::string name_of(RestHand hand) {
  constexpr std::array kNames{"reaches", "slaps", "tremor", "creep"};
  return kNames[static_cast<size_t>(hand)];
}

Soup make_spiky_sphere(uint32_t f, double roughness, uint64_t seed) {
  Dice dice(seed);
  return mapped(make_geodesic(f), [&](const Vec3& v) {
    return kRestRadius * dice.uniform(1 - roughness, 1 + roughness) * v;
  });
}

ToolPath rest_path(RestHand hand, double surface, uint64_t ticks, uint64_t seed) {
  Dice dice(seed);
  Way way(2 * surface * dice.direction(), ticks);
  const auto inside = [&] { return dice.uniform(0.3, 1.0) * surface * dice.direction(); };
  if (hand == RestHand::kCreep) follow_surface(way, dice, surface - 2e-3, 5e-3);
  if (hand == RestHand::kTremor) follow_surface(way, dice, surface - 5e-3, 0.02);
  while (!way.ends() && hand == RestHand::kReach) {
    way.reach(inside(), 0.25);
    way.reach(dice.uniform(0.6, 1.6) * surface * dice.direction(), 0.25);
  }
  while (!way.ends() && hand == RestHand::kSlap) {
    way.run(inside(), 1.5);
    way.stay(0.05);
    way.run(1.8 * surface * dice.direction(), 1.5);
  }
  std::vector<Vec3> positions = way.positions();
  if (hand == RestHand::kTremor) positions = tremble(std::move(positions), dice);
  return path_through(std::move(positions));
}

}  // namespace haptic
