// SPDX-License-Identifier: GPL-3.0-or-later
// The least depth of pairs that no walk knows: twelve kinds that mislead, from an empty state,
// against the supports of the normals of all faces and of all pairs of edges in long double.
// HAPTIC_TORTURE_SCALE=40: more than 10,000 pairs.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "contact/query/convex/convex_contact.h"
#include "tests/support/convex/hulls.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using Real = long double;

struct Point {
  Real x, y, z;
  friend Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
};
Real dot_of(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Point cross_of(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Corners of a hull at a pose, with the rotation's matrix in long double.
std::vector<Point> placed(const HullData& hull, const Pose& X) {
  const Real n = std::sqrt(Real(X.q.x) * X.q.x + Real(X.q.y) * X.q.y + Real(X.q.z) * X.q.z +
                           Real(X.q.w) * X.q.w);
  const Real x = X.q.x / n, y = X.q.y / n, z = X.q.z / n, w = X.q.w / n;
  std::vector<Point> points;
  for (const Vec3& p : hull.vertices) {
    points.push_back({(1 - 2 * (y * y + z * z)) * p.x + 2 * (x * y - z * w) * p.y +
                          2 * (x * z + y * w) * p.z + X.p.x,
                      2 * (x * y + z * w) * p.x + (1 - 2 * (x * x + z * z)) * p.y +
                          2 * (y * z - x * w) * p.z + X.p.y,
                      2 * (x * z - y * w) * p.x + 2 * (y * z + x * w) * p.y +
                          (1 - 2 * (x * x + y * y)) * p.z + X.p.z});
  }
  return points;
}

/// The smallest support of a − b over every direction that can be the normal of a facet of it.
Real least_support(const HullData& hull_a, const HullData& hull_b, const Pose& X_AB) {
  const std::vector<Point> a = placed(hull_a, {}), b = placed(hull_b, X_AB);
  Real least = std::numeric_limits<Real>::infinity();
  const auto look = [&](const Point& way) {
    const Real length = std::sqrt(dot_of(way, way));
    if (!(length > 1e-14L * 1e-4L)) return;
    for (const Real sign : {1.0L, -1.0L}) {
      const Point n{sign * way.x / length, sign * way.y / length, sign * way.z / length};
      Real most = -std::numeric_limits<Real>::infinity(), fewest = -most;
      for (const Point& p : a) most = std::max(most, dot_of(n, p));
      for (const Point& p : b) fewest = std::min(fewest, dot_of(n, p));
      least = std::min(least, most - fewest);
    }
  };
  const auto edges_of = [](const HullData& hull, const std::vector<Point>& points) {
    std::vector<Point> ways;
    for (size_t i = 0; i < hull.edges.size(); ++i) {
      const HullEdge& edge = hull.edges[i];
      if (edge.twin < i) continue;
      ways.push_back(points[hull.edges[edge.twin].from] - points[edge.from]);
    }
    return ways;
  };
  const std::vector<Point> edges_a = edges_of(hull_a, a), edges_b = edges_of(hull_b, b);
  // normals of faces are crosses of their own edges
  for (const auto* edges : {&edges_a, &edges_b}) {
    const HullData& hull = edges == &edges_a ? hull_a : hull_b;
    const std::vector<Point>& points = edges == &edges_a ? a : b;
    for (const HullFace& face : hull.faces) {
      const Point& p = points[hull.edges[face.first_edge].from];
      for (uint32_t k = 1; k + 1 < face.n_edges; ++k) {
        look(cross_of(points[hull.edges[face.first_edge + k].from] - p,
                      points[hull.edges[face.first_edge + k + 1].from] - p));
      }
    }
  }
  for (const Point& e : edges_a) {
    for (const Point& f : edges_b) look(cross_of(e, f));
  }
  return least;
}

HullData needle(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> uniform(0, 1);
  return box_hull({0.02, 0.02 * std::pow(10, -1 - 2 * uniform(engine)),
                   0.02 * std::pow(10, -1 - 2 * uniform(engine))});
}

HullData plate(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> uniform(0, 1);
  return box_hull({0.02, 0.01 + 0.01 * uniform(engine), 0.02 * std::pow(10, -2 - uniform(engine))});
}

/// A prism over an n-gon about z.
HullData prism(uint32_t n, double radius, double half) {
  std::vector<Vec3> points;
  for (uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * i / n;
    for (const double z : {-half, half}) {
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  return hull_of_points(points).hull;
}

struct KindOfPair {
  const char* name;
  HullData a, b;
  Pose X_AB;
};

/// The k-th of twelve kinds.
KindOfPair pair_of(size_t k, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto size = [&] { return static_cast<uint32_t>(4 + 20 * uniform(engine)); };
  const auto shift = [&](double most) { return most * uniform(engine) * random_direction(engine); };
  const auto slight = [&](double angle) {
    return from_rotation_vector(angle * random_direction(engine));
  };
  const HullData some = random_hull(engine, size(), 0.02),
                 other = random_hull(engine, size(), 0.02);
  const Vec3 half{0.005 + 0.02 * uniform(engine), 0.005 + 0.02 * uniform(engine),
                  0.005 + 0.02 * uniform(engine)};
  switch (k) {
    case 0:
      return {"identical", some, some, {}};
    case 1:
      return {"identical, a little aside", some, some, {shift(1e-6), slight(1e-6)}};
    case 2:
      return {"deep", some, other, {shift(1e-3), random_turn(engine)}};
    case 3:
      return {"boxes turned by rounding",
              box_hull(half),
              box_hull(half),
              {shift(0.005), slight(std::pow(10, -8 - 4 * uniform(engine)))}};
    case 4:
      return {"blobs",
              ball_hull(12 + size(), 0.02),
              ball_hull(12 + size(), 0.015),
              {shift(0.02), random_turn(engine)}};
    case 5:
      return {"plates", plate(engine), plate(engine), {shift(0.01), random_turn(engine)}};
    case 6:
      return {"needles", needle(engine), needle(engine), {shift(0.004), random_turn(engine)}};
    case 7:
      return {
          "needle in a plate", plate(engine), needle(engine), {shift(0.01), random_turn(engine)}};
    case 8:
      return {"one within the other",
              some,
              random_hull(engine, size(), 0.003),
              {shift(0.003), random_turn(engine)}};
    case 9:
      return {"prisms on one axis",
              prism(size(), 0.02, 0.01),
              prism(size(), 0.015, 0.02),
              {{0, 0, 0.02 * uniform(engine)}, from_rotation_vector({0, 0, uniform(engine)})}};
    case 10:
      return {"boxes, middles together",
              box_hull(half),
              box_hull({half.y, half.z, half.x}),
              {{}, uniform(engine) < 0.5 ? Quat{} : random_turn(engine)}};
    default:
      return {"anything", some, other, {shift(0.03), random_turn(engine)}};
  }
}

}  // namespace

TEST_CASE("least depth: of twelve kinds that mislead a walk, from an empty state", "[convex]") {
  constexpr size_t kKinds = 12;
  std::mt19937_64 engine(37);
  const size_t n = sweep(25);
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < kKinds; ++k) {
      const KindOfPair pair = pair_of(k, engine);
      const auto exact = static_cast<double>(least_support(pair.a, pair.b, pair.X_AB));
      if (!(exact > 1e-12)) continue;
      ConvexPairState state;
      const ConvexContact found = convex_contact(pair.a.view(), pair.b.view(), pair.X_AB, state);
      CAPTURE(i, pair.name, exact, found.gap, found.real);
      CHECK(found.found);
      CHECK(-found.gap == Approx(exact).epsilon(1e-9).margin(1e-12));
    }
  }
}
