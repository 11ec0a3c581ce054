// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/closest_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact/query/convex/expanding_polytope.h"

namespace haptic {
namespace {

constexpr int kMaxSteps = 200;  // a bound of the loop, far above any walk that was seen
// sine of the angle below which a way is level: 1e-14 m of distance on a hull of 10 mm
constexpr double kLevel = 1e-12;
constexpr double kTouching = 1e-15;  // distance of hulls that touch, in shares of their coordinates

constexpr HullFeature vertex(uint32_t i) {
  return {HullPart::kVertex, i};
}
constexpr HullFeature edge(uint32_t i) {
  return {HullPart::kEdge, i};
}
constexpr HullFeature face(uint32_t i) {
  return {HullPart::kFace, i};
}

/// The features that are looked at, and their nearest points in A.
struct Near {
  std::array<HullFeature, 2> feature;  // never an edge or face against a face
  std::array<Vec3, 2> point;
  double distance2 = std::numeric_limits<double>::infinity();

  void take_nearer(const Near& other) {
    if (other.distance2 < distance2) *this = other;
  }
};

enum class Step { kNearer, kNearest, kOverlap };

/// Walks over the features of both hulls, side 0 and 1, all in A.
class FeatureWalk {
 public:
  explicit FeatureWalk(const HullPair& pair) : pair_(pair) {}

  Near between(HullFeature a, HullFeature b) const;
  Step step(Near& at) const;

 private:
  const Hull& hull(int side) const { return pair_.hull(side); }
  Vec3 position(int side, uint32_t i) const { return pair_.vertex(side, i); }
  uint32_t end(int side, uint32_t e) const { return end_vertex(hull(side), e); }
  Vec3 normal(int side, uint32_t f) const {
    const Vec3& n = hull(side).faces[f].normal;
    return side == 0 ? n : pair_.R_AB * n;
  }

  Near edge_edge(uint32_t a, uint32_t b) const;
  Near feature_vertex(int side, const HullFeature& feature, uint32_t other) const;
  Near edge_vertex(int side, uint32_t e, uint32_t other) const;
  bool foot(int side, uint32_t f, const Vec3& p, Vec3& foot, double& height) const;
  HullFeature larger(int side, const HullFeature& feature, const Vec3& way) const;
  Step face_edge(int side, uint32_t f, uint32_t e, Near& at) const;
  Step through(int side, const Vec3& way, Near& at) const;
  Near ordered(int side, const HullFeature& mine, const Vec3& point, const HullFeature& theirs,
               const Vec3& other) const;

  const HullPair& pair_;
};

Near FeatureWalk::ordered(int side, const HullFeature& mine, const Vec3& point,
                          const HullFeature& theirs, const Vec3& other) const {
  const double distance2 = norm_squared(point - other);
  if (side == 0) return {{mine, theirs}, {point, other}, distance2};
  return {{theirs, mine}, {other, point}, distance2};
}

/// An edge of one side against a vertex of the other; at an end it is the vertex there.
Near FeatureWalk::edge_vertex(int side, uint32_t e, uint32_t other) const {
  const uint32_t first = hull(side).edges[e].from, last = end(side, e);
  const Vec3 p = position(side, first), way = position(side, last) - p;
  const Vec3 q = position(1 - side, other);
  const double t = dot(q - p, way) / norm_squared(way);
  if (!(t > 0)) return ordered(side, vertex(first), p, vertex(other), q);
  if (t >= 1) return ordered(side, vertex(last), p + way, vertex(other), q);
  return ordered(side, edge(e), p + t * way, vertex(other), q);
}

Near FeatureWalk::edge_edge(uint32_t a, uint32_t b) const {
  const Vec3 p = position(0, pair_.a.edges[a].from), way_a = position(0, end(0, a)) - p;
  const Vec3 q = position(1, pair_.b.edges[b].from), way_b = position(1, end(1, b)) - q;
  const double aa = norm_squared(way_a), bb = norm_squared(way_b), ab = dot(way_a, way_b);
  const Vec3 between = q - p;
  const double sine2 = aa * bb - ab * ab;
  if (sine2 > kLevel * aa * bb) {
    const double s = (dot(between, way_a) * bb - dot(between, way_b) * ab) / sine2;
    const double t = (dot(between, way_a) * ab - dot(between, way_b) * aa) / sine2;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
      return ordered(0, edge(a), p + s * way_a, edge(b), q + t * way_b);
    }
  }
  // else the nearest points are an end of one of them and a point of the other
  Near best = edge_vertex(0, a, pair_.b.edges[b].from);
  for (const Near& other : {edge_vertex(0, a, end(1, b)), edge_vertex(1, b, pair_.a.edges[a].from),
                            edge_vertex(1, b, end(0, a))}) {
    best.take_nearer(other);
  }
  return best;
}

/// The foot of p in the plane of a face, and its height above; false where the foot is beyond an
/// edge of the face.
bool FeatureWalk::foot(int side, uint32_t f, const Vec3& p, Vec3& foot, double& height) const {
  const HullFace& at = hull(side).faces[f];
  const Vec3 n = normal(side, f);
  height = dot(n, p - position(side, hull(side).edges[at.first_edge].from));
  foot = p - height * n;
  for (uint32_t k = 0; k < at.n_edges; ++k) {
    const uint32_t e = at.first_edge + k;
    const Vec3 from = position(side, hull(side).edges[e].from);
    if (dot(cross(n, position(side, end(side, e)) - from), p - from) < 0) return false;
  }
  return true;
}

Near FeatureWalk::feature_vertex(int side, const HullFeature& feature, uint32_t other) const {
  const Vec3 q = position(1 - side, other);
  if (feature.kind == HullPart::kVertex) {
    return ordered(side, feature, position(side, feature.index), vertex(other), q);
  }
  if (feature.kind == HullPart::kEdge) return edge_vertex(side, feature.index, other);
  Vec3 point;
  double height = 0;
  if (foot(side, feature.index, q, point, height)) {
    return ordered(side, feature, point, vertex(other), q);
  }
  const HullFace& at = hull(side).faces[feature.index];
  Near best;
  for (uint32_t k = 0; k < at.n_edges; ++k) {
    best.take_nearer(edge_vertex(side, at.first_edge + k, other));
  }
  return best;
}

Near FeatureWalk::between(HullFeature a, HullFeature b) const {
  if (a.kind == HullPart::kEdge && b.kind == HullPart::kEdge) {
    return edge_edge(a.index, b.index);
  }
  if (b.kind == HullPart::kVertex) return feature_vertex(0, a, b.index);
  if (a.kind != HullPart::kVertex) a = vertex(corner_of(pair_.a, a));
  return feature_vertex(1, b, a.index);
}

/// The feature around this one that leads nearer along the way to the other hull; the same where
/// none does.
HullFeature FeatureWalk::larger(int side, const HullFeature& feature, const Vec3& way_A) const {
  const Hull& h = hull(side);
  const Vec3 way = side == 0 ? way_A : transpose(pair_.R_AB) * way_A;
  const double way2 = norm_squared(way);
  HullFeature best = feature;
  double most = kLevel * kLevel * way2;
  const auto take = [&](const HullFeature& next, const Vec3& direction) {
    const double along = dot(direction, way), length2 = norm_squared(direction);
    if (along > 0 && along * along > most * length2) {
      most = along * along / length2;
      best = next;
    }
  };
  if (feature.kind == HullPart::kVertex) {
    for_edges_around(h, feature.index, [&](uint32_t e) {
      take(edge(e), h.vertices[end(side, e)] - h.vertices[feature.index]);
    });
  } else if (feature.kind == HullPart::kEdge) {
    for (const uint32_t e : {feature.index, h.edges[feature.index].twin}) {
      const uint32_t f = h.edges[e].face;
      const Vec3 along = h.vertices[end(side, e)] - h.vertices[h.edges[e].from];
      take(face(f), cross(h.faces[f].normal, along));
    }
  }
  return best;
}

/// A face of one side and an edge of the other: at an end of the edge, or at an edge of the face.
Step FeatureWalk::face_edge(int side, uint32_t f, uint32_t e, Near& at) const {
  const HullFace& polygon = hull(side).faces[f];
  const std::array<uint32_t, 2> ends{hull(1 - side).edges[e].from, end(1 - side, e)};
  std::array<double, 2> height{};
  Near best;
  for (const size_t k : {0, 1}) {
    Vec3 point;
    if (!foot(side, f, position(1 - side, ends[k]), point, height[k])) continue;
    best.take_nearer(ordered(side, face(f), point, vertex(ends[k]), position(1 - side, ends[k])));
  }
  const Vec3 p = position(1 - side, ends[0]), q = position(1 - side, ends[1]);
  if ((height[0] > 0) != (height[1] > 0)) {
    Vec3 point;
    double above = 0;
    const double share = height[0] / (height[0] - height[1]);
    if (foot(side, f, p + share * (q - p), point, above)) return Step::kOverlap;
  }
  for (uint32_t k = 0; k < polygon.n_edges; ++k) {
    const uint32_t mine = polygon.first_edge + k;
    best.take_nearer(side == 0 ? edge_edge(mine, e) : edge_edge(e, mine));
  }
  if (!(best.distance2 < at.distance2)) return Step::kNearest;
  at = best;
  return Step::kNearer;
}

/// From the foot of a vertex that is behind a face, through the hull towards the vertex.
Step FeatureWalk::through(int side, const Vec3& way_A, Near& at) const {
  const Hull& h = hull(side);
  const auto mine = static_cast<size_t>(side);
  const Mat3 R_BA = transpose(pair_.R_AB);
  const Vec3 way = side == 0 ? way_A : R_BA * way_A;
  const Vec3 from = side == 0 ? at.point[0] : R_BA * (at.point[1] - pair_.p_AB);
  double leaves = 1;
  uint32_t exit = kNoTriangle;
  for (uint32_t f = 0; f < h.faces.size(); ++f) {
    const double speed = dot(h.faces[f].normal, way);
    if (f == at.feature[mine].index || !(speed > 0)) continue;
    const double share = (h.faces[f].offset - dot(h.faces[f].normal, from)) / speed;
    if (share < leaves) leaves = share, exit = f;
  }
  if (exit == kNoTriangle) return Step::kOverlap;
  at = feature_vertex(side, face(exit), at.feature[1 - mine].index);
  return Step::kNearer;
}

Step FeatureWalk::step(Near& at) const {
  for (const int side : {0, 1}) {
    const auto mine = static_cast<size_t>(side), other = 1 - mine;
    const Vec3 way = at.point[other] - at.point[mine];
    if (at.feature[mine].kind == HullPart::kFace) {
      if (dot(normal(side, at.feature[mine].index), way) < 0) return through(side, way, at);
      continue;
    }
    const HullFeature next = larger(side, at.feature[mine], way);
    if (next == at.feature[mine]) continue;
    const bool to_face = next.kind == HullPart::kFace;
    if (to_face && at.feature[other].kind == HullPart::kEdge) {
      return face_edge(side, next.index, at.feature[other].index, at);
    }
    if (at.feature[other].kind == HullPart::kFace) {
      return face_edge(1 - side, at.feature[other].index, next.index, at);
    }
    const Near found = side == 0 ? between(next, at.feature[1]) : between(at.feature[0], next);
    if (!(found.distance2 < at.distance2)) continue;
    at = found;
    return Step::kNearer;
  }
  return Step::kNearest;
}

Vec3 normal_of(const HullPair& pair, const Near& at, const Vec3& last_A) {
  if (at.feature[0].kind == HullPart::kFace) return pair.a.faces[at.feature[0].index].normal;
  if (at.feature[1].kind == HullPart::kFace) {
    return -(pair.R_AB * pair.b.faces[at.feature[1].index].normal);
  }
  const Vec3 way = at.point[1] - at.point[0];
  return norm_squared(way) > 0 ? normalized(way) : last_A;
}

/// Walks to the end; false where the steps run out.
bool finish(const HullPair& pair, const FeatureWalk& walk, Near at, const Vec3& last_A,
            ClosestFeatures& out) {
  const double size = norm(pair.p_AB) + norm(at.point[0]) + norm(at.point[1]);
  Step step = Step::kNearer;
  int steps = 0;
  while (steps < kMaxSteps && step == Step::kNearer) {
    if (at.distance2 <= kTouching * kTouching * size * size) {
      step = Step::kOverlap;
    } else {
      step = walk.step(at);
      steps += step == Step::kNearer;
    }
  }
  out.n_steps += steps;
  out.overlap = step == Step::kOverlap;
  out.distance = out.overlap ? 0 : std::sqrt(at.distance2);
  static_cast<HullTouch&>(out) = {normal_of(pair, at, last_A), at.point[0], at.point[1],
                                  at.feature[0], at.feature[1]};
  return step != Step::kNearer;
}

}  // namespace

ClosestFeatures closest_features(const HullPair& pair, ConvexPairState& state) {
  const FeatureWalk walk(pair);
  ClosestFeatures out;
  HullFeature a = state.feature_a, b = state.feature_b;
  if (!is_feature(pair.a, a) || !is_feature(pair.b, b)) state = {}, a = b = {};
  if (norm_squared(state.normal_A) == 0) {
    const Vec3 way = pair.vertex_b(0) - pair.vertex_a(0);
    a = vertex(support_vertex(pair.a, way, 0));
    b = vertex(support_vertex(pair.b, -(transpose(pair.R_AB) * way), 0));
  }
  out.converged = finish(pair, walk, walk.between(a, b), state.normal_A, out);
  if (!out.converged) {
    const PolytopeDepth polytope = expand_polytope(pair);
    out.converged =
        finish(pair, walk, walk.between(vertex(polytope.vertex_a), vertex(polytope.vertex_b)),
               polytope.normal_A, out);
  }
  state.keep(out, false);
  return out;
}

}  // namespace haptic
