// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/redon_intervals.h"

#include "clients/lab/bench/reference/interval.h"

namespace haptic {
namespace {

/// Bounds of a corner's position over an interval of time.
Interval3 place_of(const SweptPoint& corner, const Interval& time) {
  const Interval3 from = widened<Interval>(corner.from);
  return from + time * (widened<Interval>(corner.to) - from);
}

/// Returns false only if p is certainly outside the edge from a to b of a triangle with this
/// normal.
bool may_be_within(const Interval3& normal, const Interval3& a, const Interval3& b,
                   const Interval3& p) {
  return dot(normal, cross(b - a, p - a)).hi >= 0;
}

/// True if the foot of the common perpendicular may be on the edge: 0 ≤ numerator ≤ n·n.
bool may_be_within(const Interval& numerator, const Interval& nn) {
  return numerator.hi >= 0 && numerator.lo <= nn.hi;
}

struct Places {
  Interval3 a, b, c, d;
};

Places places_of(const CcdQuery& query, const Interval& time) {
  return {place_of(query.corners[0], time), place_of(query.corners[1], time),
          place_of(query.corners[2], time), place_of(query.corners[3], time)};
}

bool may_be_flat(const Places& at, bool is_face) {
  const auto& [a, b, c, d] = at;
  const Interval volume =
      is_face ? dot(a - b, cross(c - b, d - b)) : dot(c - a, cross(b - a, d - c));
  return volume.contains(0);
}

bool may_be_within(const Places& at, bool is_face) {
  const auto& [a, b, c, d] = at;
  if (is_face) {
    const Interval3 normal = cross(c - b, d - b);
    return may_be_within(normal, b, c, a) && may_be_within(normal, c, d, a) &&
           may_be_within(normal, d, b, a);
  }
  const Interval3 e = b - a, f = d - c, r = c - a, n = cross(e, f);
  const Interval nn = squared(n.x) + squared(n.y) + squared(n.z);
  return may_be_within(dot(cross(r, f), n), nn) && may_be_within(dot(cross(r, e), n), nn);
}

}  // namespace

std::optional<double> meeting_by_intervals(const CcdQuery& query, double shortest,
                                           uint32_t budget) {
  std::array<Interval, 64> waiting;  // each bisection leaves one
  size_t n = 0;
  waiting[n++] = {0, 1};
  for (uint32_t looked = 0; n > 0; ++looked) {
    const Interval time = waiting[--n];
    if (looked >= budget) return time.lo;
    const Places at = places_of(query, time);
    if (!may_be_flat(at, query.is_face) || !may_be_within(at, query.is_face)) continue;
    if (time.width() < shortest) return time.lo;
    const double middle = 0.5 * (time.lo + time.hi);
    waiting[n++] = {middle, time.hi};
    waiting[n++] = {time.lo, middle};
  }
  return std::nullopt;
}

}  // namespace haptic
