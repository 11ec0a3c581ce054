// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <random>
#include <vector>

#include "contact/bake/convex/hull_of_points.h"
#include "proto/math/pose.h"

namespace haptic::test {

inline Vec3 random_direction(std::mt19937_64& engine) {
  std::normal_distribution<double> gauss;
  return normalized(Vec3{gauss(engine), gauss(engine), gauss(engine)});
}

inline Quat random_turn(std::mt19937_64& engine) {
  std::normal_distribution<double> gauss;
  return normalized(Quat{gauss(engine), gauss(engine), gauss(engine), gauss(engine)});
}

/// An axis-aligned box around the origin.
inline HullData box_hull(const Vec3& half) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(
        {i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
  }
  return hull_of_points(corners).hull;
}

/// A rectangle in the xy plane, two-sided.
inline HullData plate_hull(double half_x, double half_y) {
  return hull_of_points(std::vector<Vec3>{{-half_x, -half_y, 0},
                                          {half_x, -half_y, 0},
                                          {half_x, half_y, 0},
                                          {-half_x, half_y, 0}})
      .hull;
}

/// Points on the unit sphere by the golden angle, evenly spread; scaled.
inline HullData ball_hull(uint32_t n, double radius) {
  std::vector<Vec3> points;
  for (uint32_t i = 0; i < n; ++i) {
    const double z = (2.0 * i + 1) / n - 1, angle = 2.399963229728653 * i;
    const double r = std::sqrt(1 - z * z);
    points.push_back(radius * Vec3{r * std::cos(angle), r * std::sin(angle), z});
  }
  return hull_of_points(points).hull;
}

/// Random points in a ball of random half axes of 0.5 to 1, some of them inside; scaled.
inline HullData random_hull(std::mt19937_64& engine, uint32_t n, double size) {
  std::uniform_real_distribution<double> uniform(0.5, 1);
  const Vec3 half{uniform(engine), uniform(engine), uniform(engine)};
  std::vector<Vec3> points;
  for (uint32_t i = 0; i < n; ++i) {
    const Vec3 p = random_direction(engine);
    points.push_back(size * Vec3{half.x * p.x, half.y * p.y, half.z * p.z});
  }
  return hull_of_points(points).hull;
}

}  // namespace haptic::test
