// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/feature_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/query/sweep/feature_advance.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kRoom = 512;            // boxes in the queue
constexpr double kPerAxis = 0.57735026;  // 1/√3: tolerance per axis

struct Range {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  double width() const { return hi - lo; }
};

struct Box {
  double t0, t1, u0, u1, v0, v1;
};

struct Linear {
  double b, e, f;
};

/// Maximum of u e over u0 ≤ u ≤ u1, with e uncertain by `error`.
double most_of(double e, double error, double u0, double u1) {
  return (e + error) * (e + error > 0 ? u1 : u0);
}

/// Widens a range by b − u e − v f over u and v of the box. Each error is multiplied by its
/// parameter: at u = 0 the error of e vanishes, so features closer than it can still be separated.
void widen(const Linear& at, const Linear& off, const Box& box, Range& range) {
  const double most_u = most_of(at.e, off.e, box.u0, box.u1),
               most_v = most_of(at.f, off.f, box.v0, box.v1),
               least_u = -most_of(-at.e, off.e, box.u0, box.u1),
               least_v = -most_of(-at.f, off.f, box.v0, box.v1);
  // four roundings of the sum
  constexpr double kSum = 8 * kHalfStep;
  const double size = std::fabs(at.b) + off.b;
  range.lo = std::min(range.lo, at.b - off.b - most_u - most_v -
                                    kSum * (size + std::fabs(most_u) + std::fabs(most_v)));
  range.hi = std::max(range.hi, at.b + off.b - least_u - least_v +
                                    kSum * (size + std::fabs(least_u) + std::fabs(least_v)));
}

bool is_apart(const Range& range) {
  return range.lo > 0 || range.hi < 0;
}

/// Bounds of F in a box.
struct Look {
  bool may_meet;
  double size;  // largest width of F along an axis [m]
  int across;   // variable that F changes most with: 0 t, 1 u, 2 v
};

/// Along the normal of both features half-way; axes separate flat boxes poorly.
bool is_apart_along_normal(const SliceErrors& off, const Slice& s0, const Slice& s1,
                           const Box& box) {
  const Vec3 n = cross(s0.e + s1.e, s0.f + s1.f);
  const Vec3 size{std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)};
  if (!(size.x + size.y + size.z > 0)) return false;
  // three products and their sum
  constexpr double kDot = 8 * kHalfStep;
  const auto error_of = [&](const Vec3& error, const Vec3& a, const Vec3& b) {
    double error_n = dot(size, error);
    for (int k = 0; k < 3; ++k)
      error_n += kDot * size[k] * std::max(std::fabs(a[k]), std::fabs(b[k]));
    return error_n;
  };
  const Linear error{error_of(off.base, s0.base, s1.base), error_of(off.e, s0.e, s1.e),
                     error_of(off.f, s0.f, s1.f)};
  Range range;
  for (const Slice* s : {&s0, &s1}) {
    widen({dot(n, s->base), dot(n, s->e), dot(n, s->f)}, error, box, range);
  }
  return is_apart(range);
}

Look look_at_features(const FeaturePath& path, const Box& box) {
  const Slice s0 = path.at(box.t0), s1 = path.at(box.t1);
  const double deviation = path.deviation(box.t1 - box.t0);
  SliceErrors off = path.errors();
  off.base += deviation * Vec3{1, 1, 1};
  Look look{};
  double by_t = 0, by_u = 0, by_v = 0;
  for (int k = 0; k < 3; ++k) {
    Range range;
    const Linear error{off.base[k], off.e[k], off.f[k]};
    widen({s0.base[k], s0.e[k], s0.f[k]}, error, box, range);
    widen({s1.base[k], s1.e[k], s1.f[k]}, error, box, range);
    if (is_apart(range)) return look;
    look.size = std::max(look.size, range.width());
    by_t = std::max(by_t, std::fabs(s1.base[k] - s0.base[k]) + deviation +
                              box.u1 * std::fabs(s1.e[k] - s0.e[k]) +
                              box.v1 * std::fabs(s1.f[k] - s0.f[k]));
    by_u = std::max(by_u, (box.u1 - box.u0) * std::max(std::fabs(s0.e[k]), std::fabs(s1.e[k])));
    by_v = std::max(by_v, (box.v1 - box.v0) * std::max(std::fabs(s0.f[k]), std::fabs(s1.f[k])));
  }
  look.may_meet = !is_apart_along_normal(off, s0, s1, box);
  look.across = by_t >= by_u && by_t >= by_v ? 0 : by_u >= by_v ? 1 : 2;
  return look;
}

/// Splits off the later half of a box.
Box halve(Box& box, int across) {
  Box later = box;
  if (across == 0) {
    later.t0 = box.t1 = 0.5 * (box.t0 + box.t1);
  } else if (across == 1) {
    later.u0 = box.u1 = 0.5 * (box.u0 + box.u1);
  } else {
    later.v0 = box.v1 = 0.5 * (box.v0 + box.v1);
  }
  return later;
}

/// Priority queue of boxes, the earliest on top.
struct Waiting {
  struct Entry {
    Box box;
    Look look;
  };
  std::array<Entry, kRoom> entries;  // uninitialised until pushed: it is large
  size_t n = 0;

  static bool is_later(const Entry& a, const Entry& b) { return a.box.t0 > b.box.t0; }
  void push(const Entry& entry) {
    HAPTIC_ASSERT(n < entries.size());
    entries[n++] = entry;
    std::push_heap(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(n), is_later);
  }
  Entry pop() {
    std::pop_heap(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(n), is_later);
    return entries[--n];
  }
};

struct BoxSearch {
  double time = 0;            // the features are apart at every earlier time
  bool may_meet = false;      // false: they are apart along the whole path
  bool is_exhausted = false;  // the budget or the room ended the search
};

BoxSearch first_box(const FeaturePath& path, double from, double tolerance, uint32_t budget) {
  HAPTIC_ASSERT(path.begin() <= from && from <= path.end());
  const Box whole{from, path.end(), 0, 1, 0, 1};
  const Look look = look_at_features(path, whole);
  if (!look.may_meet) return {path.end(), false, false};
  Waiting waiting;
  waiting.push({whole, look});
  uint32_t looked = 1;
  while (waiting.n > 0) {
    auto [box, seen] = waiting.pop();
    // no other box begins earlier
    if (seen.size <= kPerAxis * tolerance) return {box.t0, true, false};
    if (looked + 2 > budget || waiting.n + 2 > kRoom) return {box.t0, true, true};
    const Box later = halve(box, seen.across);
    for (const Box& half : {box, later}) {
      if (path.is_triangle() && half.u0 + half.v0 > 1) continue;
      ++looked;
      const Look at = look_at_features(path, half);
      if (at.may_meet) waiting.push({half, at});
    }
  }
  return {path.end(), false, false};
}

}  // namespace

std::optional<SweptMeeting> meeting_by_boxes(const FeaturePath& path, double tolerance,
                                             uint32_t budget) {
  if (!path.is_finite()) return SweptMeeting{path.begin(), false};
  const Advance advanced = advance(path, tolerance);
  if (advanced.end == Advance::End::kApart) return std::nullopt;
  const BoxSearch search = first_box(path, advanced.time, tolerance, budget);
  if (!search.may_meet) return std::nullopt;
  const bool is_near = advanced.end == Advance::End::kNear && search.time == advanced.time;
  return SweptMeeting{search.time, is_near || !search.is_exhausted};
}

std::optional<SweptMeeting> meeting_by_boxes(const CcdQuery& query, double tolerance,
                                             uint32_t budget) {
  // most are apart along an axis, which costs least
  if (!meeting_of(query, tolerance)) return std::nullopt;
  const auto& [a, b, c, d] = query.corners;
  return meeting_by_boxes(query.is_face ? FeaturePath::of_vertex_and_face(a, {b, c, d})
                                        : FeaturePath::of_edges({a, b}, {c, d}),
                          tolerance, budget);
}

}  // namespace haptic
