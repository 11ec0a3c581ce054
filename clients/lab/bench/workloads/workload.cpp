// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/workload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "clients/lab/support/dice.h"
#include "clients/lab/support/scan.h"
#include "clients/lab/support/soups.h"
#include "contact/query/point/segment_hit.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

double lattice_value(int64_t x, int64_t y, int64_t z) {
  SplitMix random(static_cast<uint64_t>(x) * 0x9E3779B1 ^
                  (static_cast<uint64_t>(y) << 21) * 0x85EBCA77 ^
                  (static_cast<uint64_t>(z) << 42) * 0xC2B2AE3D ^ 0x1234567);
  random.next();
  return random.uniform();
}

/// Value noise in [−1, 1] with continuous slope.
double value_noise(const Vec3& p) {
  const std::array<double, 3> low{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  std::array<double, 3> f{p.x - low[0], p.y - low[1], p.z - low[2]};
  for (double& q : f) q = q * q * q * (q * (q * 6 - 15) + 10);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1, dy = (i >> 1) & 1, dz = (i >> 2) & 1;
    const double weight = (dx ? f[0] : 1 - f[0]) * (dy ? f[1] : 1 - f[1]) * (dz ? f[2] : 1 - f[2]);
    sum +=
        weight * lattice_value(static_cast<int64_t>(low[0]) + dx, static_cast<int64_t>(low[1]) + dy,
                               static_cast<int64_t>(low[2]) + dz);
  }
  return 2 * sum - 1;
}

double octaves(Vec3 p, int n) {
  double amplitude = 1, sum = 0;
  for (int i = 0; i < n; ++i, amplitude *= 0.5) {
    sum += amplitude * value_noise(p);
    p = 2.03 * p + Vec3{17.1, 3.7, 9.2};
  }
  return sum;
}

Vec3 rounded_to_float(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// A point of the surface with its outward normal.
struct SurfacePoint {
  Vec3 p_O, normal_O;
};

/// First hit of a segment.
std::optional<SurfacePoint> look_at(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  const SegmentHit hit = first_hit(shape, from_O, to_O);
  if (!hit.hit) return std::nullopt;
  return SurfacePoint{from_O + hit.t * (to_O - from_O), shape.mesh.face_normals[hit.triangle]};
}

std::optional<SurfacePoint> look_towards_origin(const MeshShape& shape, const Vec3& u) {
  return look_at(shape, 200 * kMm * u, -200 * kMm * u);
}

/// The base point after a path of s radians.
std::optional<SurfacePoint> base_point(const MeshShape& shape, SurfaceKind kind, double s) {
  if (kind == SurfaceKind::kHeightField) {
    const double x = 45 * kMm * std::sin(0.37 * s), y = 45 * kMm * std::sin(0.911 * s + 1);
    return look_at(shape, {x, y, 100 * kMm}, {x, y, -100 * kMm});
  }
  const double latitude = 0.193 * s;
  return look_towards_origin(shape, {std::cos(s) * std::cos(latitude),
                                     std::sin(s) * std::cos(latitude), std::sin(latitude)});
}

/// Motion in one tick [rad on a circle of 50 mm].
double step_of(double t) {
  const double speed = 0.05 + 1.95 * (0.5 + 0.5 * std::sin(2 * kPi * 0.7 * t)) *
                                  (0.5 + 0.5 * std::sin(2 * kPi * 0.113 * t));
  return speed / 50;
}

}  // namespace

WorkloadMesh make_bump_sphere(uint32_t frequency) {
  const auto place = [](const Vec3& u) {
    return rounded_to_float(kMm * (50 + 4 * octaves(3.0 * u, 5)) * u);
  };
  return {"sphere " + std::to_string(20 * frequency * frequency), SurfaceKind::kSphere,
          mapped(make_geodesic(frequency), place)};
}

WorkloadMesh make_nano_surface(uint32_t n) {
  WorkloadMesh mesh{"nano " + std::to_string(2 * n * n), SurfaceKind::kHeightField, {}};
  for (uint32_t i = 0; i <= n; ++i) {
    for (uint32_t j = 0; j <= n; ++j) {
      const double x = -50 + 100.0 * i / n, y = -50 + 100.0 * j / n;
      const double z = 6 * octaves({0.05 * x, 0.05 * y, 0.5}, 8);
      mesh.soup.vertices.push_back(rounded_to_float({kMm * x, kMm * y, kMm * z}));
    }
  }
  for (uint32_t i = 0; i < n; ++i) {
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t a = i * (n + 1) + j, b = a + n + 1, c = b + 1, d = a + 1;
      mesh.soup.triangles.insert(mesh.soup.triangles.end(), {{a, b, c}, {a, c, d}});
    }
  }
  return mesh;
}

WorkloadMesh make_scanned(const std::string& name, Soup soup) {
  Vec3 lower = soup.vertices.at(0), upper = lower;
  for (const Vec3& v : soup.vertices) {
    lower = component_min(lower, v);
    upper = component_max(upper, v);
  }
  const Vec3 side = upper - lower;
  const double scale = 100 * kMm / std::max({side.x, side.y, side.z});
  const auto place = [&](const Vec3& v) {
    return rounded_to_float(scale * (v - 0.5 * (lower + upper)));
  };
  return {name, SurfaceKind::kSphere, mapped(std::move(soup), place)};
}

std::vector<WorkloadSegment> dragged_segments(const MeshShape& shape, SurfaceKind kind, size_t n) {
  constexpr double kLift = 0.02 * kMm, kJump = 3 * kMm, kShortest = 0.05 * kMm,
                   kLongest = 2.5 * kMm;
  std::vector<WorkloadSegment> segments;
  std::optional<Vec3> before;
  double s = 0;
  for (size_t i = 0; segments.size() < n && i < 40 * n; ++i) {
    const double t = kTick * static_cast<double>(i);
    s += step_of(t);
    const std::optional<SurfacePoint> base = base_point(shape, kind, s);
    const bool follows = base && before && norm(base->p_O - *before) <= kJump;
    if (follows) {
      const double height =
          kMm * (0.9 * std::sin(2 * kPi * 3.1 * t) + 0.3 * std::sin(2 * kPi * 11.3 * t));
      const Vec3 from = rounded_to_float(*before + kLift * base->normal_O);
      const Vec3 to = rounded_to_float(base->p_O + height * base->normal_O);
      const double length = norm(to - from);
      if (length >= kShortest && length <= kLongest) segments.push_back({from, to});
    }
    before = base ? std::optional(base->p_O) : std::nullopt;
  }
  return segments;
}

std::vector<Vec3> dragged_points(const MeshShape& shape, SurfaceKind kind, size_t n) {
  std::vector<Vec3> points;
  double s = 0;
  for (size_t i = 0; points.size() < n && i < 10 * n; ++i) {
    const double t = kTick * static_cast<double>(i);
    s += step_of(t);
    const std::optional<SurfacePoint> base = base_point(shape, kind, s);
    if (!base) continue;
    points.push_back(
        rounded_to_float(base->p_O + kMm * std::sin(2 * kPi * 3.1 * t) * base->normal_O));
  }
  return points;
}

std::vector<Vec3> far_points(const MeshShape& shape, SurfaceKind kind, size_t n) {
  SplitMix random(7);
  std::vector<Vec3> points;
  for (size_t i = 0; points.size() < n && i < 10 * n; ++i) {
    const std::optional<SurfacePoint> base =
        kind == SurfaceKind::kSphere ? look_towards_origin(shape, direction_in_ball(random))
                                     : base_point(shape, kind, random.uniform(0, 1000));
    const double height = random.uniform(0, 20);
    if (base) points.push_back(rounded_to_float(base->p_O + kMm * height * base->normal_O));
  }
  return points;
}

WorkloadMesh read_scanned(const std::string& name, const std::string& file) {
  const BakedShape baked = bake_scan(file, 0.1);
  const TriangleMesh& mesh = baked.shape.mesh;
  return make_scanned(name, {{mesh.vertices.begin(), mesh.vertices.end()},
                             {mesh.triangles.begin(), mesh.triangles.end()}});
}

}  // namespace haptic
