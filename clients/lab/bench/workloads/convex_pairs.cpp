// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/convex_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "clients/lab/support/dice.h"
#include "contact/query/convex/expanding_polytope.h"

namespace haptic {
namespace {

constexpr Vec3 kHalfAxes{20e-3, 14e-3, 10e-3};  // [m]
constexpr int kTries = 12;            // directions, of which the farthest from the others is taken
constexpr double kLeastDepth = 1e-5;  // [m]

double farthest(std::span<const Vec3> points, const Vec3& way) {
  double reach = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : points) reach = std::max(reach, dot(way, p));
  return reach;
}

}  // namespace

std::vector<Vec3> make_convex_points(uint32_t n, uint64_t seed) {
  SplitMix random(seed);
  std::vector<Vec3> directions, points;
  while (directions.size() < n) {
    Vec3 best;
    double most = -1;
    for (int k = 0; k < kTries; ++k) {
      const Vec3 direction = direction_in_ball(random);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vec3& d : directions) nearest = std::min(nearest, norm(d - direction));
      if (nearest > most) most = nearest, best = direction;
    }
    directions.push_back(best);
    const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    points.push_back({rounded(kHalfAxes.x * best.x), rounded(kHalfAxes.y * best.y),
                      rounded(kHalfAxes.z * best.z)});
  }
  return points;
}

std::vector<Pose> make_convex_poses(const Hull& a, const Hull& b, size_t n) {
  const Vec3 axis = normalized(Vec3{1, 2, 3});
  std::vector<Pose> poses;
  for (size_t i = 0; poses.size() < n && i < 4 * n; ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    const double azimuth = 3.5 * t + 1, height = 0.6 * std::sin(2.1 * t);
    const Vec3 way{std::cos(azimuth) * std::cos(height), std::sin(azimuth) * std::cos(height),
                   std::sin(height)};
    const Quat q = normalized(from_rotation_vector((1.7 * t + 0.3) * axis) *
                              from_rotation_vector({0, 0.9 * t, 0}));
    const double overlap = 1e-3 * (2 + 1.8 * std::sin(2 * std::numbers::pi * 1.3 * t));
    const double reach =
        farthest(a.vertices, way) + farthest(b.vertices, -rotate(conjugate(q), way));
    const Pose X_AB{(reach - overlap) * way, q};
    if (expand_polytope(HullPair(a, b, X_AB)).depth >= kLeastDepth) poses.push_back(X_AB);
  }
  return poses;
}

}  // namespace haptic
