// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/convex/brute.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace haptic::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Edge {
  Vec3 from, way, left, right;  // the normals of its faces
};

/// A hull placed in another frame.
struct Placed {
  std::vector<Vec3> vertices, normals;
  std::vector<Edge> edges;
  const Hull& hull;

  Placed(const Hull& h, const Pose& X) : hull(h) {
    for (const Vec3& p : h.vertices) vertices.push_back(X * p);
    for (const HullFace& f : h.faces) normals.push_back(rotate(X.q, f.normal));
    for (uint32_t i = 0; i < h.edges.size(); ++i) {
      const HullEdge &e = h.edges[i], &twin = h.edges[e.twin];
      if (e.twin < i) continue;
      edges.push_back({vertices[e.from], vertices[twin.from] - vertices[e.from], normals[e.face],
                       normals[twin.face]});
    }
  }
  double reach(const Vec3& way) const {
    double most = -kInfinity;
    for (const Vec3& p : vertices) most = std::max(most, dot(way, p));
    return most;
  }
  const Vec3& corner(const HullFace& face, uint32_t k) const {
    return vertices[hull.edges[face.first_edge + k % face.n_edges].from];
  }
};

/// Whether the arcs from a to b and from c to d, each shorter than half a circle, cross.
bool cross_arcs(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = cross(a, b), cd = cross(c, d);
  const double c_side = dot(ab, c), d_side = dot(ab, d), a_side = dot(cd, a), b_side = dot(cd, b);
  return c_side * d_side < 0 && a_side * b_side < 0 && c_side * b_side > 0;
}

double above_faces(const Placed& a, const Placed& b) {
  double least = kInfinity;
  for (size_t f = 0; f < a.hull.faces.size(); ++f) {
    const HullFace& face = a.hull.faces[f];
    const Vec3& n = a.normals[f];
    for (const Vec3& p : b.vertices) {
      const double height = dot(n, p - a.corner(face, 0));
      bool over = height >= 0 && height < least;
      for (uint32_t k = 0; over && k < face.n_edges; ++k) {
        const Vec3 way = a.corner(face, k + 1) - a.corner(face, k);
        over = dot(cross(n, way), p - a.corner(face, k)) >= 0;
      }
      if (over) least = height;
    }
  }
  return least;
}

double of_segments(const Edge& a, const Edge& b) {
  const double aa = norm_squared(a.way), bb = norm_squared(b.way), ab = dot(a.way, b.way);
  const Vec3 between = b.from - a.from;
  const double sine2 = aa * bb - ab * ab;
  double s = 0;
  if (sine2 > 1e-14 * aa * bb) {
    s = std::clamp((dot(between, a.way) * bb - dot(between, b.way) * ab) / sine2, 0.0, 1.0);
  }
  const double t = std::clamp(dot(a.from + s * a.way - b.from, b.way) / bb, 0.0, 1.0);
  s = std::clamp(dot(between + t * b.way, a.way) / aa, 0.0, 1.0);
  return norm(between + t * b.way - s * a.way);
}

}  // namespace

double brute_penetration(const Hull& hull_a, const Hull& hull_b, const Pose& X_AB) {
  const Placed a(hull_a, {}), b(hull_b, X_AB);
  double least = kInfinity;
  for (size_t f = 0; f < a.normals.size(); ++f) {
    const Vec3& n = a.normals[f];
    least = std::min(least, dot(n, a.corner(hull_a.faces[f], 0)) + b.reach(-n));
  }
  for (size_t f = 0; f < b.normals.size(); ++f) {
    const Vec3& n = b.normals[f];
    least = std::min(least, dot(n, b.corner(hull_b.faces[f], 0)) + a.reach(-n));
  }
  for (const Edge& p : a.edges) {
    for (const Edge& q : b.edges) {
      if (!cross_arcs(p.left, p.right, -q.left, -q.right)) continue;
      Vec3 n = normalized(cross(p.way, q.way));
      if (dot(n, p.left + p.right) < 0) n = -n;
      least = std::min(least, dot(n, p.from - q.from));
    }
  }
  return least;
}

double brute_distance(const Hull& hull_a, const Hull& hull_b, const Pose& X_AB) {
  const Placed a(hull_a, {}), b(hull_b, X_AB);
  double least = std::min(above_faces(a, b), above_faces(b, a));
  for (const Edge& p : a.edges) {
    for (const Edge& q : b.edges) least = std::min(least, of_segments(p, q));
  }
  return least;
}

}  // namespace haptic::test
