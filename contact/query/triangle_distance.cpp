// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle_distance.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "contact/query/patch_lanes.h"

namespace haptic {
namespace {

using Double4 [[gnu::vector_size(32)]] = double;

// pairs of parts: sides 3 i + j, then corners of b on the face of a, then corners of a on that of b
constexpr int kSidePairs = 9, kFaceOfB = 12;

/// Three coordinates of one triangle, or of four.
template <class Real>
struct Vec {
  Real x, y, z;
};
template <class Real>
HAPTIC_INLINE Vec<Real> operator+(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
HAPTIC_INLINE Vec<Real> operator-(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
HAPTIC_INLINE Vec<Real> operator*(const Real& s, const Vec<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
HAPTIC_INLINE Real dot(const Vec<Real>& a, const Vec<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
HAPTIC_INLINE Vec<Real> cross(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class Real>
HAPTIC_INLINE Real all(double value) {
  return Real{} + value;
}
/// 0 for what is not a number.
template <class Real>
HAPTIC_INLINE Real within_unit(const Real& x) {
  const Real above = x > all<Real>(0) ? x : all<Real>(0);
  return above < all<Real>(1) ? above : all<Real>(1);
}
template <class Real>
HAPTIC_INLINE Real reciprocal(const Real& x) {
  return x > all<Real>(0) ? all<Real>(1) / x : all<Real>(0);
}
template <class Real>
HAPTIC_INLINE Real smaller(const Real& a, const Real& b) {
  return a < b ? a : b;
}
template <class Real>
HAPTIC_INLINE Real larger(const Real& a, const Real& b) {
  return a > b ? a : b;
}

/// A triangle with what all its pairs need.
template <class Real>
struct Prepared {
  Vec<Real> p[3], d[3];  // corners; side i goes from corner i along d
  Real length2[3], per_length2[3];
  Vec<Real> normal, inward[3];  // in the plane, from side i
  Real normal2, per_normal2;
};

template <class Real>
HAPTIC_INLINE Prepared<Real> prepared(const Vec<Real>& p0, const Vec<Real>& p1,
                                      const Vec<Real>& p2) {
  Prepared<Real> t;
  t.p[0] = p0, t.p[1] = p1, t.p[2] = p2;
  t.d[0] = p1 - p0, t.d[1] = p2 - p1, t.d[2] = p0 - p2;
  t.normal = cross(t.d[0], t.d[1]);
  t.normal2 = dot(t.normal, t.normal);
  t.per_normal2 = reciprocal(t.normal2);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    t.length2[i] = dot(t.d[i], t.d[i]);
    t.per_length2[i] = reciprocal(t.length2[i]);
    t.inward[i] = cross(t.normal, t.d[i]);
  }
  return t;
}

/// The nearest pair of parts so far: how near, which, where, and the way from a to b.
template <class Real>
struct Nearest {
  Real distance2, parts, along_a, along_b;
  Vec<Real> way;
};

template <class Real, class Mask>
HAPTIC_INLINE void replace(Nearest<Real>& best, const Mask& where, const Nearest<Real>& other) {
  best.distance2 = where ? other.distance2 : best.distance2;
  best.parts = where ? other.parts : best.parts;
  best.along_a = where ? other.along_a : best.along_a;
  best.along_b = where ? other.along_b : best.along_b;
  best.way.x = where ? other.way.x : best.way.x;
  best.way.y = where ? other.way.y : best.way.y;
  best.way.z = where ? other.way.z : best.way.z;
}

/// Side i of a and side j of b: the closest points of their lines, each moved into its side in
/// turn (Ericson 2005, §5.1.9).
template <class Real>
HAPTIC_INLINE Nearest<Real> between_sides(const Prepared<Real>& a, int i, const Prepared<Real>& b,
                                          int j) {
  const Vec<Real> r = a.p[i] - b.p[j];
  const Real along = dot(a.d[i], b.d[j]), c = dot(a.d[i], r), f = dot(b.d[j], r);
  const Real sine2 = a.length2[i] * b.length2[j] - along * along;
  Real s = within_unit((along * f - c * b.length2[j]) * reciprocal(sine2));
  const Real t = within_unit((along * s + f) * b.per_length2[j]);
  s = within_unit((along * t - c) * a.per_length2[i]);
  const Vec<Real> way = t * b.d[j] - (r + s * a.d[i]);
  return {dot(way, way), all<Real>(3 * i + j), s, t, way};
}

/// A corner over the face of t, where it is over it; `sign` 1 where the face is a's.
template <class Real>
HAPTIC_INLINE void try_face(Nearest<Real>& best, const Prepared<Real>& t, const Vec<Real>& corner,
                            int parts, double sign) {
  const Real height = dot(t.normal, corner - t.p[0]) * t.per_normal2;
  const Real distance2 = height * height * t.normal2;
  const Real zero = all<Real>(0);
  const Real inside =
      smaller(smaller(dot(t.inward[0], corner - t.p[0]), dot(t.inward[1], corner - t.p[1])),
              dot(t.inward[2], corner - t.p[2]));
  const auto is_nearer = (inside > zero) & (t.normal2 > zero) & (distance2 < best.distance2);
  const Vec<Real> way = (all<Real>(sign) * height) * t.normal;
  replace(best, is_nearer, {distance2, all<Real>(parts), height, zero, way});
}

/// The nearest of the fifteen pairs of parts.
template <class Real>
HAPTIC_INLINE Nearest<Real> nearest_parts(const Prepared<Real>& a, const Prepared<Real>& b) {
  Nearest<Real> best = between_sides(a, 0, b, 0);
#pragma GCC unroll 9
  for (int k = 1; k < kSidePairs; ++k) {
    const Nearest<Real> other = between_sides(a, k / 3, b, k % 3);
    replace(best, other.distance2 < best.distance2, other);
  }
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) try_face(best, a, b.p[k], kSidePairs + k, 1);
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) try_face(best, b, a.p[k], kFaceOfB + k, -1);
  return best;
}

/// How far b is in front of a along the way between them, times its length: more than 0 is a proof
/// that they do not meet, and the square of the distance where the way is right.
template <class Real>
HAPTIC_INLINE Real gap_along(const Prepared<Real>& a, const Prepared<Real>& b,
                             const Vec<Real>& way) {
  const Vec<Real> across = b.p[0] - a.p[0];
  const Real b0 = dot(way, across), b1 = b0 + dot(way, b.d[0]), b2 = b0 - dot(way, b.d[2]);
  const Real a1 = dot(way, a.d[0]), a2 = all<Real>(0) - dot(way, a.d[2]);
  return smaller(smaller(b0, b1), b2) - larger(larger(a1, a2), all<Real>(0));
}

HAPTIC_INLINE Vec<double> to_vec(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Prepared<double> prepared(const Corners& c) {
  return prepared(to_vec(c[0]), to_vec(c[1]), to_vec(c[2]));
}

TrianglePart part_of_side(int side, double along) {
  const int end = along <= 0 ? side : along >= 1 ? (side + 1) % 3 : 3 + side;
  return static_cast<TrianglePart>(end);
}

Vec3 on_side(const Corners& c, int side, double along) {
  const Vec3 &from = c[static_cast<size_t>(side)], &to = c[static_cast<size_t>(side + 1) % 3];
  if (along >= 1) return to;
  return from + along * (to - from);
}

/// The point of the plane of the triangle below a corner, `height` normals above it.
Vec3 below(const Corners& c, const Vec3& corner, double height) {
  return corner - height * haptic::cross(c[1] - c[0], c[2] - c[1]);
}

/// Places and parts in words.
TriangleDistance described(const Corners& a, const Corners& b, double distance2, int parts,
                           double along_a, double along_b) {
  const double distance = std::sqrt(distance2);
  if (parts < kSidePairs) {
    const int i = parts / 3, j = parts % 3;
    return {distance, on_side(a, i, along_a), on_side(b, j, along_b), part_of_side(i, along_a),
            part_of_side(j, along_b)};
  }
  const int corner = parts % 3;
  const auto k = static_cast<size_t>(corner);
  const auto part = static_cast<TrianglePart>(corner);
  if (parts < kFaceOfB) return {distance, below(a, b[k], along_a), b[k], TrianglePart::kFace, part};
  return {distance, a[k], below(b, a[k], along_a), part, TrianglePart::kFace};
}

/// Whether the gap is a proof that they are apart.
template <class Real>
HAPTIC_INLINE auto is_apart(const Real& gap, const Real& distance2) {
  return gap > all<Real>(0.5) * distance2;
}

template <class Real>
HAPTIC_INLINE Vec<Real> load(const DistanceBatch::Lanes* lanes, size_t i) {
  Vec<Real> v;
  std::memcpy(&v.x, &lanes[0][i], sizeof v.x);
  std::memcpy(&v.y, &lanes[1][i], sizeof v.y);
  std::memcpy(&v.z, &lanes[2][i], sizeof v.z);
  return v;
}
template <class Real>
HAPTIC_INLINE void store(const Real& v, DistanceBatch::Lanes& lanes, size_t i) {
  std::memcpy(&lanes[i], &v, sizeof v);
}
template <class Real>
HAPTIC_INLINE void store(const Vec<Real>& v, DistanceBatch::Lanes* lanes, size_t i) {
  store(v.x, lanes[0], i), store(v.y, lanes[1], i), store(v.z, lanes[2], i);
}

/// Corner of b as X_AB * p, operation by operation, and kept so.
template <class Real>
HAPTIC_INLINE Vec<Real> move_corner(const Pose& X_AB, DistanceBatch::Lanes* corner, size_t i) {
  const Vec<Real> p = load<Real>(corner, i);
  const Vec<Real> u{all<Real>(X_AB.q.x), all<Real>(X_AB.q.y), all<Real>(X_AB.q.z)};
  const Vec<Real> t = all<Real>(2) * cross(u, p);
  const Vec<Real> turned = p + all<Real>(X_AB.q.w) * t + cross(u, t);
  const Vec<Real> origin{all<Real>(X_AB.p.x), all<Real>(X_AB.p.y), all<Real>(X_AB.p.z)};
  const Vec<Real> moved = origin + turned;
  store(moved, corner, i);
  return moved;
}

/// All of a batch but for what only the exact test can tell: a bit for each of those.
template <class Real>
HAPTIC_INLINE uint64_t measure_lanes(const Pose& X_AB, DistanceBatch& batch) {
  constexpr size_t kWidth = sizeof(Real) / sizeof(double);
  static_assert(DistanceBatch::kRoom % kWidth == 0);
  uint64_t unsure = 0;
  for (size_t i = 0; i < batch.n; i += kWidth) {
    const Prepared<Real> a = prepared(load<Real>(&batch.a[0], i), load<Real>(&batch.a[3], i),
                                      load<Real>(&batch.a[6], i));
    const Prepared<Real> b =
        prepared(move_corner<Real>(X_AB, &batch.b[0], i), move_corner<Real>(X_AB, &batch.b[3], i),
                 move_corner<Real>(X_AB, &batch.b[6], i));
    const Nearest<Real> best = nearest_parts(a, b);
    const Real gap = gap_along(a, b, best.way);
    store(best.distance2, batch.distance_squared, i);
    store(gap, batch.gap, i);
    store(best.parts, batch.parts, i);
    store(best.along_a, batch.along_a, i);
    store(best.along_b, batch.along_b, i);
    store(best.way, batch.way.data(), i);
    const auto apart = is_apart(gap, best.distance2);
    for (size_t k = 0; k < kWidth; ++k) unsure |= uint64_t{apart[k] == 0} << (i + k);
  }
  return unsure;
}

HAPTIC_WIDE uint64_t measure_wide(const Pose& X_AB, DistanceBatch& batch) {
  return measure_lanes<Double4>(X_AB, batch);
}

}  // namespace

TriangleDistance triangle_distance(const Corners& a, const Corners& b) {
  const Prepared<double> side_a = prepared(a), side_b = prepared(b);
  const Nearest<double> best = nearest_parts(side_a, side_b);
  const bool apart = is_apart(gap_along(side_a, side_b, best.way), best.distance2);
  const double distance2 = apart || !triangles_meet(a, b) ? best.distance2 : 0;
  return described(a, b, distance2, static_cast<int>(best.parts), best.along_a, best.along_b);
}

size_t distances_of_parts(const Corners& a, const Corners& b,
                          std::array<TriangleDistance, kTrianglePartPairs>& out) {
  const Prepared<double> side_a = prepared(a), side_b = prepared(b);
  size_t n = 0;
  const auto add = [&](const Nearest<double>& at) {
    out[n++] = described(a, b, at.distance2, static_cast<int>(at.parts), at.along_a, at.along_b);
  };
  for (int k = 0; k < kSidePairs; ++k) add(between_sides(side_a, k / 3, side_b, k % 3));
  for (int k = 0; k < 6; ++k) {
    Nearest<double> best{std::numeric_limits<double>::infinity(), -1, 0, 0, {}};
    const bool on_a = k < 3;
    if (on_a) {
      try_face(best, side_a, side_b.p[k], kSidePairs + k, 1);
    } else {
      try_face(best, side_b, side_a.p[k - 3], kSidePairs + k, -1);
    }
    if (best.parts >= 0) add(best);
  }
  return n;
}

void DistanceBatch::add(const Corners& corners_A, const Corners& corners_B) {
  for (size_t k = 0; k < 3; ++k) {
    a[3 * k][n] = corners_A[k].x, a[3 * k + 1][n] = corners_A[k].y,
          a[3 * k + 2][n] = corners_A[k].z;
    b[3 * k][n] = corners_B[k].x, b[3 * k + 1][n] = corners_B[k].y,
          b[3 * k + 2][n] = corners_B[k].z;
  }
  ++n;
}

Corners DistanceBatch::corners_a(size_t i) const {
  return {{{a[0][i], a[1][i], a[2][i]}, {a[3][i], a[4][i], a[5][i]}, {a[6][i], a[7][i], a[8][i]}}};
}

Corners DistanceBatch::corners_b(size_t i) const {
  return {{{b[0][i], b[1][i], b[2][i]}, {b[3][i], b[4][i], b[5][i]}, {b[6][i], b[7][i], b[8][i]}}};
}

void measure(const Pose& X_AB, DistanceBatch& batch) {
  const uint64_t unsure = measure_wide(X_AB, batch);
  for (size_t i = 0; i < batch.n; ++i) {
    if ((unsure >> i & 1) == 0) continue;
    if (triangles_meet(batch.corners_a(i), batch.corners_b(i))) batch.distance_squared[i] = 0;
  }
}

TriangleDistance measured(const DistanceBatch& batch, size_t i) {
  return described(batch.corners_a(i), batch.corners_b(i), batch.distance_squared[i],
                   static_cast<int>(batch.parts[i]), batch.along_a[i], batch.along_b[i]);
}

}  // namespace haptic
