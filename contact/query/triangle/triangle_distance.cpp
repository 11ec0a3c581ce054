// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/triangle_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/query/triangle/triangle_lanes.h"
#include "contact/query/triangle/triangles_by_eight.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

using namespace triangle_lanes;
using Double4 [[gnu::vector_size(32)]] = double;

HAPTIC_INLINE Vec<double> lanes_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Prepared<double> prepared(const Corners& c) {
  return prepared(lanes_of(c[0]), lanes_of(c[1]), lanes_of(c[2]));
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

/// The projection of a corner onto the plane of the triangle; `height` is in lengths of its normal.
Vec3 below(const Corners& c, const Vec3& corner, double height) {
  return corner - height * haptic::cross(c[1] - c[0], c[2] - c[1]);
}

/// Result with closest points and parts.
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

HAPTIC_WIDE uint64_t measure_by_four(const Pose& X_AB, DistanceBatch& batch) {
  return measure_lanes<Double4>(X_AB, batch);
}

/// Measures as many pairs at a time as the processor supports.
uint64_t measure_wide(const Pose& X_AB, DistanceBatch& batch) {
  static const bool has_eight = can_measure_by_eight();
  return has_eight ? measure_by_eight(X_AB, batch) : measure_by_four(X_AB, batch);
}

/// Whether a side of a passes through the interior of b by more than any rounding; true of most
/// pairs that meet.
bool surely_pierces(const Prepared<double>& a, const Prepared<double>& b) {
  constexpr double kSure = 1e-9;
  double height[3];
  for (int i = 0; i < 3; ++i) height[i] = dot(b.normal, a.p[i] - b.p[0]);
  for (int i = 0; i < 3; ++i) {
    const double from = height[i], to = height[(i + 1) % 3];
    const Vec<double> r = a.p[i] - b.p[0];
    const double sure = kSure * kSure * b.normal2 * (a.length2[i] + dot(r, r));
    if (!(from * to < 0) || !(std::min(from * from, to * to) > sure)) continue;
    const Vec<double> through = a.p[i] + (from / (from - to)) * a.d[i];
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
      inside = inside && dot(b.inward[k], through - b.p[k]) > kSure * b.normal2;
    }
    if (inside) return true;
  }
  return false;
}

bool is_thin(const Prepared<double>& t) {
  constexpr double kLeastSine2 = 1e-8;
  return !(t.normal2 > kLeastSine2 * t.length2[0] * t.length2[1]);
}

/// triangles_meet, mostly without the exact test.
bool meet(const Corners& a, const Corners& b) {
  const Prepared<double> side_a = prepared(a), side_b = prepared(b);
  if (!is_thin(side_a) && !is_thin(side_b)) {
    if (surely_pierces(side_a, side_b) || surely_pierces(side_b, side_a)) return true;
  }
  return triangles_meet(a, b);
}

}  // namespace

TriangleDistance triangle_distance(const Corners& a, const Corners& b) {
  const Prepared<double> side_a = prepared(a), side_b = prepared(b);
  const Nearest<double> best = nearest_parts(side_a, side_b);
  const bool apart = is_apart(gap_along(side_a, side_b, best.way), best.distance2);
  const double distance2 = apart || !meet(a, b) ? best.distance2 : 0;
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

void measure(const Pose& X_AB, DistanceBatch& batch) {
  HAPTIC_ASSERT(batch.n <= DistanceBatch::kRoom);
  const uint64_t unsure = measure_wide(X_AB, batch);
  for (size_t i = 0; i < batch.n; ++i) {
    if ((unsure >> i & 1) == 0) continue;
    if (meet(batch.corners_a(i), batch.corners_b(i))) batch.distance_squared[i] = 0;
  }
}

TriangleDistance measured(const DistanceBatch& batch, size_t i) {
  HAPTIC_ASSERT(i < batch.n);
  return described(batch.corners_a(i), batch.corners_b(i), batch.distance_squared[i],
                   static_cast<int>(batch.parts[i]), batch.along_a[i], batch.along_b[i]);
}

}  // namespace haptic
