// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/convex/meshes.h"
#include "proto/math/units.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic::test {
namespace {

/// Adds the two triangles of a quad, counter-clockwise as seen from outside.
void add_quad(Soup& soup, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  soup.triangles.push_back({a, b, c});
  soup.triangles.push_back({a, c, d});
}

constexpr std::array<std::array<double, 2>, 6> kL{
    {{0, 0}, {1, 0}, {1, 0.5}, {0.5, 0.5}, {0.5, 1}, {0, 1}}};

}  // namespace

Soup make_flat_l(double side) {
  Soup soup;
  for (const auto& [x, y] : kL) soup.vertices.push_back({side * x, side * y, 0});
  soup.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  return soup;
}

Soup make_l_shape(double side, double height) {
  Soup soup = make_flat_l(side);
  const auto n = static_cast<uint32_t>(kL.size());
  for (uint32_t i = 0; i < n; ++i) soup.vertices.push_back(soup.vertices[i] + Vec3{0, 0, height});
  for (size_t i = 0; i < 4; ++i) {
    Triangle& floor = soup.triangles[i];
    const Triangle roof{floor[0] + n, floor[1] + n, floor[2] + n};
    std::swap(floor[1], floor[2]);
    soup.triangles.push_back(roof);
  }
  for (uint32_t i = 0; i < n; ++i) add_quad(soup, i, (i + 1) % n, (i + 1) % n + n, i + n);
  return soup;
}

Soup make_height_sheet(double half, uint32_t n, const std::function<double(double, double)>& f) {
  Soup soup = make_grid(half, n);
  for (Vec3& v : soup.vertices) v.z = f(v.x, v.y);
  return soup;
}

Soup make_dented_ball(double radius, uint32_t subdivisions, double angle, double depth) {
  Soup soup = make_icosphere(radius, subdivisions);
  for (Vec3& v : soup.vertices) {
    const double share = std::acos(std::clamp(v.z / radius, -1.0, 1.0)) / angle;
    if (share < 1) v = (1 - depth / radius * 0.5 * (1 + std::cos(kPi * share))) * v;
  }
  return soup;
}

Soup make_bumpy_ball(double radius, uint32_t subdivisions, double share, double k) {
  Soup soup = make_icosphere(radius, subdivisions);
  for (Vec3& v : soup.vertices) {
    const Vec3 n = normalized(v);
    v = radius * (1 + share * std::sin(k * n.x) * std::sin(k * n.y) * std::sin(k * n.z)) * n;
  }
  return soup;
}

Soup make_torus(double ring, double tube, uint32_t n, uint32_t m) {
  Soup soup;
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < m; ++j) {
      const double a = 2 * kPi * i / n, b = 2 * kPi * j / m, r = ring + tube * std::cos(b);
      soup.vertices.push_back({r * std::cos(a), r * std::sin(a), tube * std::sin(b)});
      const uint32_t next_i = (i + 1) % n * m, next_j = (j + 1) % m;
      add_quad(soup, i * m + j, next_i + j, next_i + next_j, i * m + next_j);
    }
  }
  return soup;
}

Soup make_spiral_strip(double radius, double width, double turns, uint32_t n) {
  Soup soup;
  for (uint32_t i = 0; i <= n; ++i) {
    const double share = static_cast<double>(i) / n, angle = 2 * kPi * turns * share;
    const double r = radius * (1 + share);
    soup.vertices.push_back({r * std::cos(angle), r * std::sin(angle), 0});
    soup.vertices.push_back({r * std::cos(angle), r * std::sin(angle), width});
    if (i > 0) add_quad(soup, 2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1);
  }
  return soup;
}

Soup make_cap_over_needle(double radius) {
  const double flat = 1 / (4 * radius);
  Soup soup = make_height_sheet(0.5 * radius, 16,
                                [&](double x, double y) { return -flat * (x * x + y * y); });
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  const double reach = 0.1 * radius;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * kPi * i / 3;
    soup.vertices.push_back({reach * std::cos(angle), reach * std::sin(angle), -radius});
  }
  soup.vertices.push_back({0, 0, -0.02 * radius});
  for (uint32_t i = 0; i < 3; ++i) {
    soup.triangles.push_back({first + i, first + (i + 1) % 3, first + 3});
  }
  soup.triangles.push_back({first, first + 2, first + 1});
  return soup;
}

}  // namespace haptic::test
