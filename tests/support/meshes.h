// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "contact/shape/mesh_shape.h"
#include "proto/math/pose.h"
#include "tests/support/data.h"

namespace haptic::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr size_t kSlowdown = 20;
#else
inline constexpr size_t kSlowdown = 1;
#endif

/// Number of random trials, fewer where a sanitizer slows each one down.
constexpr size_t trials(size_t n) {
  return n / kSlowdown > 0 ? n / kSlowdown : 1;
}

/// Uniform random numbers and what is made of them, from a fixed seed.
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
  /// Around the mesh: its box grown by half its size on every side.
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

/// Reads a plain OFF file of triangles, independent of the baker; scaled so that the longest side
/// is `size` metres. No triangles where the mesh is absent.
inline Soup load_off(const std::string& name, double size) {
  const auto path = find_mesh(name);
  Soup soup;
  if (!path) return soup;
  std::ifstream in(*path);
  std::string magic;
  size_t n_vertices = 0, n_triangles = 0, ignored = 0;
  in >> magic >> n_vertices >> n_triangles >> ignored;
  soup.vertices.resize(n_vertices);
  soup.triangles.resize(n_triangles);
  for (Vec3& v : soup.vertices) in >> v.x >> v.y >> v.z;
  for (Triangle& t : soup.triangles) in >> ignored >> t[0] >> t[1] >> t[2];
  Vec3 lower = soup.vertices.at(0), upper = lower;
  for (const Vec3& v : soup.vertices) {
    lower = component_min(lower, v);
    upper = component_max(upper, v);
  }
  const Vec3 side = upper - lower;
  const double scale = size / std::max({side.x, side.y, side.z});
  for (Vec3& v : soup.vertices) v = scale * (v - 0.5 * (lower + upper));
  return soup;
}

/// A sheet of n × n quads over 0.1 m × 0.1 m as rough as it is fine: slopes of `slope`, all random.
inline Soup make_rough_sheet(uint64_t seed, uint32_t n, double slope) {
  Random random(seed);
  Soup soup = make_grid(0.05, n);
  for (Vec3& v : soup.vertices) v.z = slope * 0.05 / n * random.uniform(-1, 1);
  return soup;
}

/// Unconnected random triangles, some of them without area, some of them twice.
inline Soup make_degenerate_soup(uint64_t seed, size_t n) {
  Random random(seed);
  Soup soup;
  for (size_t i = 0; i < n; ++i) {
    const Vec3 at = random.in_box({-1, -1, -1}, {1, 1, 1});
    Vec3 p[3] = {at, at + 0.2 * random.direction(), at + 0.2 * random.direction()};
    if (i % 5 == 1) p[2] = p[1];
    if (i % 5 == 2) p[2] = p[0] + random.uniform(-1, 2) * (p[1] - p[0]);
    if (i % 5 == 3) p[1] = p[2] = p[0];
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), p, p + 3);
    soup.triangles.push_back({first, first + 1, first + 2});
    if (i % 7 == 0) soup.triangles.push_back(soup.triangles.back());
  }
  return soup;
}

}  // namespace haptic::test
