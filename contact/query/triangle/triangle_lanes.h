// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <cstring>

#include "contact/query/simd/lanes8.h"
#include "contact/query/triangle/distance_batch.h"
#include "proto/math/pose.h"

/// Distance of one pair of triangles, or of four or eight at a time: the same operations in the
/// same order for any Real, a double or a vector of doubles. All functions are inlined into callers
/// compiled for an instruction set.
namespace haptic::triangle_lanes {

// indices of pairs of parts: sides 3 i + j, then corners of b over the face of a, then corners of a
// over that of b
inline constexpr int kSidePairs = 9, kFaceOfB = 12;

/// Three coordinates of one triangle, or of several.
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
/// Limits x to [0, 1]; not-a-number gives 0.
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

/// A triangle with everything that its pairs share.
template <class Real>
struct Prepared {
  Vec<Real> p[3], d[3];  // corners and sides: side i goes from corner i along d
  Real length2[3], per_length2[3];
  Vec<Real> normal, inward[3];  // in the plane, normal to side i
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

/// The nearest pair of parts so far: squared distance, index, parameters, and vector from a to b.
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

/// Side i of a and side j of b: the closest points of their lines, each clamped to its side in turn
/// (Ericson 2005, §5.1.9).
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

/// A corner and the face of t, if the corner lies over it; `sign` is 1 if the face is a's.
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

/// Gap of a and b along the vector between them, times its length: positive proves that they are
/// apart; the squared distance if the vector is exact.
template <class Real>
HAPTIC_INLINE Real gap_along(const Prepared<Real>& a, const Prepared<Real>& b,
                             const Vec<Real>& way) {
  const Vec<Real> across = b.p[0] - a.p[0];
  const Real b0 = dot(way, across), b1 = b0 + dot(way, b.d[0]), b2 = b0 - dot(way, b.d[2]);
  const Real a1 = dot(way, a.d[0]), a2 = all<Real>(0) - dot(way, a.d[2]);
  return smaller(smaller(b0, b1), b2) - larger(larger(a1, a2), all<Real>(0));
}

/// Whether the gap proves that they are apart.
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

/// Corner of b as X_AB * p, in the same order of operations; stored.
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

/// Measures a batch; returns a bit for each pair that needs the exact test.
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

}  // namespace haptic::triangle_lanes
