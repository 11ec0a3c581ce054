// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/touching_point.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kEdgeRounding = 1e-12;  // of a place along an edge, in shares of its length

/// A feature of either hull as a polygon in A: an edge has two corners, a vertex one.
struct Outline {
  const HullPair& pair;
  int side;
  HullFeature feature;
  Vec3 lift;  // moves B onto A

  uint32_t size() const {
    if (feature.kind == HullPart::kVertex) return 1;
    if (feature.kind == HullPart::kEdge) return 2;
    return pair.hull(side).faces[feature.index].n_edges;
  }
  Vec3 operator[](uint32_t k) const {
    const Hull& hull = pair.hull(side);
    uint32_t vertex = feature.index;
    if (feature.kind == HullPart::kEdge) {
      vertex = k == 0 ? hull.edges[feature.index].from : end_vertex(hull, feature.index);
    } else if (feature.kind == HullPart::kFace) {
      vertex = hull.edges[hull.faces[feature.index].first_edge + k].from;
    }
    return side == 0 ? pair.vertex_a(vertex) : pair.vertex_b(vertex) + lift;
  }
};

/// The part of the segment from p to q inside a polygon seen along n, counter-clockwise for `turn`
/// 1, clockwise for −1; false if there is none.
bool clip(const Outline& polygon, const Vec3& n, double turn, const Vec3& p, const Vec3& q,
          double& from, double& to) {
  from = 0, to = 1;
  const uint32_t size = polygon.size();
  for (uint32_t k = 0; k < size; ++k) {
    const Vec3 corner = polygon[k];
    const Vec3 inward = turn * cross(n, polygon[k + 1 < size ? k + 1 : 0] - corner);
    const double at_p = dot(inward, p - corner), at_q = dot(inward, q - corner);
    if (at_p < 0 && at_q < 0) return false;
    if (at_p < 0) from = std::max(from, at_p / (at_p - at_q));
    if (at_q < 0) to = std::min(to, at_p / (at_p - at_q));
  }
  return from <= to + kEdgeRounding;
}

/// Where two lines that cross, seen along n, do so; in their middle where they are parallel.
Vec3 crossing(const Outline& a, const Outline& b, const Vec3& n) {
  const Vec3 p = a[0], way = a[1] - p, q = b[0], other = b[1] - q, side = cross(n, other);
  const double sine = dot(way, side), length2 = norm_squared(way);
  if (sine * sine > kEdgeRounding * kEdgeRounding * length2 * norm_squared(other)) {
    return p + std::clamp(dot(q - p, side) / sine, 0.0, 1.0) * way;
  }
  const double s = dot(q - p, way) / length2, t = dot(b[1] - p, way) / length2;
  const double from = std::max(std::min(s, t), 0.0), to = std::min(std::max(s, t), 1.0);
  return p + std::clamp((from + to) / 2, 0.0, 1.0) * way;
}

/// Middle of the parts of the outline of `inner` that lie in the polygon.
void add_clipped(const Outline& inner, const Outline& polygon, const Vec3& n, double turn,
                 Vec3& sum, double& count) {
  const uint32_t size = inner.size();
  for (uint32_t k = 0; k + 1 < size + (size > 2); ++k) {
    const Vec3 p = inner[k], q = inner[k + 1 < size ? k + 1 : 0];
    double from = 0, to = 1;
    if (!clip(polygon, n, turn, p, q, from, to)) continue;
    sum += 2 * p + (from + to) * (q - p);
    count += 2;
  }
}

}  // namespace

Vec3 touching_point(const HullPair& pair, const OverlayVertex& at) {
  const Vec3& n = at.normal[0];
  const Vec3 lift = at.depth * n;
  const Outline a{pair, 0, at.feature[0], lift}, b{pair, 1, at.feature[1], lift};
  Vec3 point;
  if (a.size() == 1) {
    point = a[0];
  } else if (b.size() == 1) {
    point = b[0];
  } else if (a.size() == 2 && b.size() == 2) {
    point = crossing(a, b, n);
  } else {
    // a face of b is seen from behind along n
    double count = 0;
    if (a.size() > 2) add_clipped(b, a, n, 1, point, count);
    if (b.size() > 2) add_clipped(a, b, n, -1, point, count);
    point = count > 0 ? point / count : b[0];
  }
  return point;
}

}  // namespace haptic
