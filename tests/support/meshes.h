// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"
#include "tests/support/data.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

/// Uniform random numbers, vectors, poses and points from a fixed seed.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  size_t index(size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(engine_); }
  Vec3 in_box(const Vec3& lower, const Vec3& upper) {
    return {uniform(lower.x, upper.x), uniform(lower.y, upper.y), uniform(lower.z, upper.z)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_box({-1, -1, -1}, {1, 1, 1});
      if (norm_squared(v) > 1e-4 && norm_squared(v) < 1) return normalized(v);
    }
  }
  /// A rigid motion with origin within `reach` of zero.
  Pose pose(double reach) {
    return {reach * direction(), from_rotation_vector(uniform(0, 3) * direction())};
  }
  /// Around the mesh: in its box, enlarged by half its size on every side.
  Vec3 near_mesh(const TriangleMesh& mesh) {
    const Vec3 margin = 0.5 * (mesh.upper - mesh.lower);
    return in_box(mesh.lower - margin, mesh.upper + margin);
  }
  /// On a random triangle, uniform in barycentric coordinates.
  Vec3 on_surface(const TriangleMesh& mesh) {
    const Triangle& tri = mesh.triangles[index(mesh.triangles.size())];
    double u = uniform(0, 1), v = uniform(0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]], &c = mesh.vertices[tri[2]];
    return a + u * (b - a) + v * (c - a);
  }

 private:
  std::mt19937_64 engine_;
};

/// Adds a surface to another, displaced.
inline void append(Soup& soup, const Soup& other, const Vec3& at = {}) {
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  for (const Vec3& v : other.vertices) soup.vertices.push_back(v + at);
  for (const auto& [a, b, c] : other.triangles) {
    soup.triangles.push_back({first + a, first + b, first + c});
  }
}

/// A ball whose vertices lie at random up to 15 % deeper.
inline Soup make_bumpy_ball(uint64_t seed, double radius, uint32_t subdivisions) {
  Random random(seed);
  Soup soup = make_icosphere(radius, subdivisions);
  for (Vec3& v : soup.vertices) v = random.uniform(0.85, 1) * v;
  return soup;
}

/// Reads a plain OFF file of triangles, independent of the baker, scaled so that the longest side
/// is `size` metres. No triangles if the file is absent.
Soup load_off(const std::string& name, double size);

/// A sheet of n × n quads over 0.1 m × 0.1 m with random slopes of `slope`.
Soup make_rough_sheet(uint64_t seed, uint32_t n, double slope);

/// Unconnected random triangles, some of zero area, some duplicated.
Soup make_degenerate_soup(uint64_t seed, size_t n);

}  // namespace haptic::test
