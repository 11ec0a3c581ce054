// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <vector>

#include "contact/shape/mesh/primitives.h"
#include "contact/shape/parts/vessel.h"
#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// Distance from the z axis and height of a ring [m].
struct Ring {
  double r, z;
};

/// Adds the rings of a straight profile, without its first, in steps of at most `step` [m].
void add_line(std::vector<Ring>& profile, const Ring& to, double step) {
  const Ring from = profile.back();
  const double length = std::hypot(to.r - from.r, to.z - from.z);
  const int n = std::max(1, static_cast<int>(std::ceil(length / step)));
  for (int i = 1; i <= n; ++i) {
    const double t = static_cast<double>(i) / n;
    profile.push_back({from.r + t * (to.r - from.r), from.z + t * (to.z - from.z)});
  }
}

/// The rings of a sphere about the origin from its pole -z to a polar angle [rad]: `rings` for the
/// cap, which ends at the equator at the latest, then rows as far apart.
std::vector<Ring> spherical(double radius, double angle, uint32_t rings) {
  const double cap = std::min(angle, 0.5 * kPi), step = cap / rings;
  const auto rows = static_cast<uint32_t>(std::ceil((angle - cap) / step - 1e-9));
  std::vector<Ring> profile;
  for (uint32_t k = 0; k <= rings + rows; ++k) {
    const double beyond = k > rings ? (angle - cap) * (k - rings) / rows : 0;
    const double at = k > rings ? cap + beyond : step * k;
    profile.push_back({radius * std::sin(at), -radius * std::cos(at)});
  }
  return profile;
}

Soup spun(const std::vector<Ring>& profile, uint32_t rings, bool faces_down) {
  const auto at = [&](uint32_t ring, double theta) {
    const auto& [r, z] = profile[ring];
    return Vec3{r * std::cos(theta), r * std::sin(theta), z};
  };
  const auto rows = static_cast<uint32_t>(profile.size()) - 1 - rings;
  return make_vessel(at, {0, 0, profile.back().z}, {rings, rows}, faces_down);
}

uint32_t rings_of(uint32_t around) {
  HAPTIC_ASSERT(around >= 6);
  return around / 6;
}

}  // namespace

Soup make_joint_ball(const primitive::JointBall& ball) {
  const double radius = 0.5 * ball.diameter, stem = 0.5 * ball.stem;
  HAPTIC_ASSERT(0 < stem && stem < radius && ball.length > radius);
  const uint32_t rings = rings_of(ball.around);
  std::vector<Ring> profile = spherical(radius, kPi - std::asin(stem / radius), rings);
  add_line(profile, {stem, ball.length}, 0.5 * kPi * radius / rings);
  return spun(profile, rings, true);
}

Soup make_joint_socket(const primitive::JointSocket& socket) {
  const double radius = 0.5 * socket.diameter + socket.clearance, outer = 0.5 * socket.width;
  HAPTIC_ASSERT(radius < outer && radius < socket.height);
  const uint32_t rings = rings_of(socket.around);
  const double step = 0.5 * kPi * radius / rings;
  std::vector<Ring> profile = spherical(radius, socket.cover, rings);
  add_line(profile, {outer, profile.back().z}, step);
  add_line(profile, {outer, -socket.height}, step);
  return spun(profile, rings, false);
}

}  // namespace haptic
