// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/triangle_distance.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/cgal_pairs.h"
#include "tests/support/meshes.h"
#include "tests/support/tolerance.h"

using namespace haptic;
using namespace haptic::test;

namespace {

struct Long3 {
  long double x, y, z;
};
Long3 operator-(const Long3& a, const Long3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Long3 along(const Long3& a, const Long3& d, long double t) {
  return {a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}
long double dot(const Long3& a, const Long3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Long3 to_long(const Vec3& v) {
  return {v.x, v.y, v.z};
}
long double length(const Long3& a) {
  return std::sqrt(dot(a, a));
}

long double point_segment(const Long3& p, const Long3& a, const Long3& b) {
  const Long3 d = b - a;
  const long double l = dot(d, d);
  const long double t = l > 0 ? std::clamp(dot(p - a, d) / l, 0.0L, 1.0L) : 0;
  return length(p - along(a, d, t));
}

/// The least of the four ends, or the distance of the lines if both feet are inside.
long double segment_segment(const Long3& a, const Long3& b, const Long3& c, const Long3& d) {
  long double least = std::min({point_segment(a, c, d), point_segment(b, c, d),
                                point_segment(c, a, b), point_segment(d, a, b)});
  const Long3 u = b - a, v = d - c, w = a - c;
  const long double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  if (det > 0) {
    const long double s = (uv * dot(v, w) - vv * dot(u, w)) / det;
    const long double t = (uu * dot(v, w) - uv * dot(u, w)) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
      least = std::min(least, length(along(a, u, s) - along(c, v, t)));
    }
  }
  return least;
}

/// If p is above the inside of the triangle, by coordinates in its plane; else by its sides.
long double point_face(const Long3& p, const Long3& a, const Long3& b, const Long3& c) {
  const Long3 u = b - a, v = c - a, w = p - a;
  const long double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  if (!(det > 0)) return std::numeric_limits<long double>::infinity();
  const long double s = (vv * dot(u, w) - uv * dot(v, w)) / det;
  const long double t = (uu * dot(v, w) - uv * dot(u, w)) / det;
  if (s < 0 || t < 0 || s + t > 1) return std::numeric_limits<long double>::infinity();
  return length(w - along(along({0, 0, 0}, u, s), v, t));
}

double sampled_distance(const Corners& a, const Corners& b) {
  Long3 p[3], q[3];
  for (size_t i = 0; i < 3; ++i) p[i] = to_long(a[i]), q[i] = to_long(b[i]);
  long double least = std::numeric_limits<long double>::infinity();
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      least = std::min(least, segment_segment(p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3]));
    }
    least =
        std::min({least, point_face(p[i], q[0], q[1], q[2]), point_face(q[i], p[0], p[1], p[2])});
  }
  return static_cast<double>(least);
}

bool is_spread(const Corners& c) {
  return norm_squared(cross(c[1] - c[0], c[2] - c[0])) > 0;
}

Corners random_corners(Random& random, double reach) {
  Corners c;
  for (Vec3& p : c) p = random.in_box({-reach, -reach, -reach}, {reach, reach, reach});
  return c;
}

/// Far from the part of the triangle that is to carry it.
double off_part(const Corners& c, TrianglePart part, const Vec3& point) {
  const auto k = static_cast<size_t>(part);
  const Long3 p = to_long(point);
  if (k < 3) return norm(point - c[k]);
  if (k < 6) {
    return static_cast<double>(point_segment(p, to_long(c[k - 3]), to_long(c[(k - 2) % 3])));
  }
  return static_cast<double>(point_face(p, to_long(c[0]), to_long(c[1]), to_long(c[2])));
}

}  // namespace

TEST_CASE("triangle distance: fifteen pairs of parts in long double, 0 where CGAL says they meet") {
  Random random(1);
  size_t n_meeting = 0;
  for (size_t trial = 0; trial < trials(60000); ++trial) {
    Corners a = random_corners(random, 1), b = random_corners(random, 1);
    // on a lattice: parallel sides and faces, shared corners; thin; close by
    if (trial % 4 == 1) {
      for (Corners* c : {&a, &b}) {
        for (Vec3& p : *c) p = {std::round(2 * p.x), std::round(2 * p.y), std::round(p.z)};
      }
    }
    if (trial % 4 == 2) a[2] = a[0] + 0.7 * (a[1] - a[0]) + 1e-6 * random.direction();
    if (trial % 4 == 3) {
      for (size_t i = 0; i < 3; ++i) b[i] = a[i] + Vec3{0, 0, 1e-4} + 0.1 * random.direction();
    }
    const bool meet = is_spread(a) && is_spread(b) && cgal_triangles_meet(a, b);
    const TriangleDistance found = triangle_distance(a, b);
    CAPTURE(trial);
    n_meeting += meet;
    if (meet) {
      REQUIRE(found.distance == 0);
      continue;
    }
    const double expected = sampled_distance(a, b);
    REQUIRE(std::fabs(found.distance - expected) < tol(2e-8));
    // only sides that are nearly parallel and nearly touch lose digits
    if (trial % 4 != 2 && expected > 1e-3) {
      REQUIRE(std::fabs(found.distance - expected) < tol(1e-12));
    }
    REQUIRE(norm(found.point_b - found.point_a) == Approx(found.distance).margin(tol(1e-12)));
    REQUIRE(off_part(a, found.part_a, found.point_a) < tol(1e-9));
    REQUIRE(off_part(b, found.part_b, found.point_b) < tol(1e-9));
    REQUIRE(std::fabs(triangle_distance(b, a).distance - found.distance) < tol(2e-8));
  }
  CHECK(n_meeting > trials(60000) / 20);
}

TEST_CASE("triangle distance: many side by side as one by one, to the bit") {
  Random random(2);
  for (size_t trial = 0; trial < trials(500); ++trial) {
    const Pose X_AB = random.pose(0.5);
    DistanceBatch batch;
    std::vector<Corners> all_a, all_b;
    const size_t n = 1 + random.index(DistanceBatch::kRoom);
    for (size_t i = 0; i < n; ++i) {
      all_a.push_back(random_corners(random, 1));
      all_b.push_back(random_corners(random, 1));
      batch.add(all_a.back(), all_b.back());
    }
    measure(X_AB, batch);
    for (size_t i = 0; i < n; ++i) {
      Corners b;
      for (size_t k = 0; k < 3; ++k) b[k] = X_AB * all_b[i][k];
      REQUIRE(batch.corners_b(i) == b);
      const TriangleDistance one = triangle_distance(all_a[i], b), of_many = measured(batch, i);
      REQUIRE(of_many.distance == one.distance);
      REQUIRE(of_many.point_a == one.point_a);
      REQUIRE(of_many.point_b == one.point_b);
      REQUIRE(of_many.part_a == one.part_a);
      REQUIRE(of_many.part_b == one.part_b);
    }
  }
}

TEST_CASE("triangle distance: planes across the way are as far apart as is said") {
  Random random(3);
  for (size_t trial = 0; trial < trials(200); ++trial) {
    DistanceBatch batch;
    for (size_t i = 0; i < DistanceBatch::kRoom; ++i) {
      batch.add(random_corners(random, 1), random_corners(random, 1));
    }
    measure({}, batch);
    for (size_t i = 0; i < batch.n; ++i) {
      if (batch.distance_squared[i] == 0) continue;
      const Vec3 way{batch.way[0][i], batch.way[1][i], batch.way[2][i]};
      double low = 1e9, high = -1e9;
      for (const Vec3& p : batch.corners_b(i)) low = std::min(low, dot(way, p));
      for (const Vec3& p : batch.corners_a(i)) high = std::max(high, dot(way, p));
      REQUIRE(batch.gap[i] == Approx(low - high).margin(tol(1e-12)));
      REQUIRE(batch.gap[i] == Approx(batch.distance_squared[i]).margin(tol(1e-7)));
    }
  }
}

TEST_CASE("triangle distance: by hand, which parts carry it") {
  const Corners a{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const auto check = [&](const Corners& b, double distance, TrianglePart on_a, TrianglePart on_b) {
    const TriangleDistance found = triangle_distance(a, b);
    CHECK(found.distance == Approx(distance));
    CHECK(found.part_a == on_a);
    CHECK(found.part_b == on_b);
  };
  check({{{1, 1, 2}, {1, 1, 3}, {2, 1, 3}}}, 2, TrianglePart::kFace, TrianglePart::kCorner0);
  check({{{-1, 0, 1}, {-1, 0, 5}, {-3, 0, 5}}}, std::sqrt(2), TrianglePart::kCorner0,
        TrianglePart::kCorner0);
  check({{{2, -1, -1}, {2, -1, 1}, {2, -5, 0}}}, 1, TrianglePart::kSide0, TrianglePart::kSide0);
  CHECK(triangle_distance(a, {{{1, 1, -1}, {1, 1, 3}, {8, 8, 3}}}).distance == 0);
  // a triangle without area equals its border, also where it pierces the face
  CHECK(triangle_distance(a, {{{1, 1, 1}, {1, 1, 2}, {1, 1, 3}}}).distance == Approx(1));
  CHECK(triangle_distance(a, {{{5, 0, 0}, {5, 0, 0}, {5, 0, 0}}}).distance == Approx(1));
}

TEST_CASE("triangle distance: each pair of parts by itself has the distance among them") {
  Random random(4);
  for (size_t trial = 0; trial < trials(2000); ++trial) {
    const Corners a = random_corners(random, 1);
    Corners b = random_corners(random, 1);
    for (Vec3& p : b) p.x += 2;
    std::array<TriangleDistance, kTrianglePartPairs> parts;
    const size_t n = distances_of_parts(a, b, parts);
    REQUIRE(n >= 9);
    double least = 1e9;
    for (size_t i = 0; i < n; ++i) least = std::min(least, parts[i].distance);
    REQUIRE(least == triangle_distance(a, b).distance);
  }
}
