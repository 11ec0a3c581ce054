// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/parts/dimpled_ball.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kDimpleSteps = 6;  // 10·6² + 2 dimples

/// The dimples' middles, sorted by z so that a search sees one belt of them.
std::vector<Vec3> dimple_middles() {
  std::vector<Vec3> middles = make_geodesic(kDimpleSteps).vertices;
  HAPTIC_ASSERT(middles.size() == kDimples);
  std::sort(middles.begin(), middles.end(), [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
  return middles;
}

/// Share of a dimple's depth at a direction: 1 in its middle, 0 at its rim and outside. A dimple is
/// a paraboloid with a sharp rim.
double dimple_at(const std::vector<Vec3>& middles, const Vec3& direction) {
  const auto first = std::lower_bound(middles.begin(), middles.end(), direction.z - kDimpleAngle,
                                      [](const Vec3& m, double z) { return m.z < z; });
  for (auto m = first; m != middles.end() && m->z <= direction.z + kDimpleAngle; ++m) {
    const double angle = 2 * std::asin(std::min(1.0, 0.5 * norm(direction - *m)));
    if (angle < kDimpleAngle) return 1 - (angle / kDimpleAngle) * (angle / kDimpleAngle);
  }
  return 0;
}

}  // namespace

Soup make_dimpled_ball(const primitive::DimpledBall& ball) {
  const double radius = 0.5 * ball.diameter;
  HAPTIC_ASSERT(ball.depth >= 0 && ball.depth < radius);
  const std::vector<Vec3> middles = dimple_middles();
  Soup soup = make_geodesic(ball.along);
  for (Vec3& v : soup.vertices) v *= radius - ball.depth * dimple_at(middles, v);
  return soup;
}

}  // namespace haptic
