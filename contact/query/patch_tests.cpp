// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/patch_tests.h"

#include <cstring>
#include <limits>

// twice the width where the processor has it; sanitizers do not stand the choice at load time
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HAPTIC_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define HAPTIC_WIDE
#endif
#define HAPTIC_INLINE __attribute__((always_inline)) inline

namespace haptic {
namespace {

using Float8 __attribute__((vector_size(32))) = float;
using Int8 __attribute__((vector_size(32))) = int32_t;

constexpr float kUlp = 1.2e-7F;     // a whole rounding
constexpr float kError = 2;         // steps: one of the leaf, and the roundings of the point
constexpr float kSumError = 1e-5F;  // of a sum of squares
// of the longest vector in play, squared: what the products of a triangle cancel, not too thin
constexpr float kCancelled = 5e-5F;
constexpr float kWayRoundings = 32;  // of the largest coordinate, in the sums of a way's tests
constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

HAPTIC_INLINE Float8 splat(float x) {
  return x - Float8{};
}

template <class Vector, class Lanes>
HAPTIC_INLINE Vector load(const Lanes& lanes) {
  Vector v;
  static_assert(sizeof v == sizeof lanes);
  std::memcpy(&v, lanes.data(), sizeof v);
  return v;
}

HAPTIC_INLINE Float8 larger(Float8 a, Float8 b) {
  return a > b ? a : b;
}
HAPTIC_INLINE Float8 smaller(Float8 a, Float8 b) {
  return a < b ? a : b;
}

HAPTIC_INLINE float least(Float8 v) {
  v = smaller(v, __builtin_shuffle(v, Int8{4, 5, 6, 7, 0, 1, 2, 3}));
  v = smaller(v, __builtin_shuffle(v, Int8{2, 3, 0, 1, 6, 7, 4, 5}));
  v = smaller(v, __builtin_shuffle(v, Int8{1, 0, 3, 2, 5, 4, 7, 6}));
  return v[0];
}

HAPTIC_INLINE LaneSet lanes_of(Int8 mask) {
  Int8 v = mask & Int8{1, 2, 4, 8, 16, 32, 64, 128};
  v |= __builtin_shuffle(v, Int8{4, 5, 6, 7, 0, 1, 2, 3});
  v |= __builtin_shuffle(v, Int8{2, 3, 0, 1, 6, 7, 4, 5});
  return LaneSet(static_cast<uint32_t>(v[0] | v[1]));
}

struct Vec8 {
  Float8 x, y, z;
};
HAPTIC_INLINE Vec8 operator-(const Vec8& a, const Vec8& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HAPTIC_INLINE Float8 dot(const Vec8& a, const Vec8& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// In steps of the leaf from its origin, as everything below.
HAPTIC_INLINE Vec8 corner(const PatchLeaf& leaf, size_t i) {
  const Int8 word = load<Int8>(leaf.corners[i]);
  return {__builtin_convertvector(word & 1023, Float8),
          __builtin_convertvector((word >> 10) & 1023, Float8),
          __builtin_convertvector(word >> 20, Float8)};
}

HAPTIC_INLINE Vec8 operator+(const Vec8& a, const Vec8& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HAPTIC_INLINE Vec8 operator*(Float8 s, const Vec8& v) {
  return {s * v.x, s * v.y, s * v.z};
}
HAPTIC_INLINE Vec8 splat(float x, float y, float z) {
  return {splat(x), splat(y), splat(z)};
}
HAPTIC_INLINE Vec8 load_rows(const std::array<PatchNode::Lanes, 3>& rows) {
  return {load<Float8>(rows[0]), load<Float8>(rows[1]), load<Float8>(rows[2])};
}

/// A point in steps of the leaf.
HAPTIC_INLINE Vec8 in_steps(const PatchLeaf& leaf, const Vec3& p_O) {
  const float per_step = 1 / leaf.step;
  const auto from_origin = [&](int k) {
    const auto origin = static_cast<double>(leaf.origin[static_cast<size_t>(k)]);
    return splat(per_step * static_cast<float>(p_O[k] - origin));
  };
  return {from_origin(0), from_origin(1), from_origin(2)};
}

/// Whether a plane across u stays between a sphere of that reach and what is `gap` away along u
/// (times |u|) from where it starts, all the way d.
HAPTIC_INLINE Int8 stays_off(const Vec8& u, Float8 gap, const Vec8& d, Float8 reach) {
  const Float8 least = gap + smaller(dot(u, d), splat(0));
  return (least > splat(0)) & (least * least > dot(u, u) * reach * reach);
}

/// Where along start + 2 slope u + curvature u² it is least, for u in [0, 1].
HAPTIC_INLINE Float8 least_at(Float8 slope, Float8 curvature) {
  return smaller(larger(-slope / curvature, splat(0)), splat(1));
}

/// Least value of start + 2 slope u + curvature u² for u in [0, 1]: a squared distance along a
/// side.
HAPTIC_INLINE Float8 least_along(Float8 start, Float8 slope, Float8 curvature) {
  const Float8 u = least_at(slope, curvature);
  return start + u * (2 * slope + curvature * u);
}

}  // namespace

PatchProbe::PatchProbe(const Vec3& p) : p_O(p) {
  float slacks = 0;
  for (int k = 0; k < 3; ++k) {
    const auto row = static_cast<size_t>(k);
    const auto x = static_cast<float>(p[k]);
    const float ulp = kUlp * (x < 0 ? -x : x);
    at[row].fill(x), below[row].fill(x - ulp), above[row].fill(x + ulp);
    slacks += 4 * ulp;  // a rounding of p, one of the product, two of the sum
  }
  slack.fill(slacks);
}

WayProbe::WayProbe(const Vec3& start, const Vec3& way, double r, double furthest)
    : from_O(start),
      length(round_up_distance(norm(way))),
      radius(round_up_distance(r) * (1 + kSumError)),
      slack(kWayRoundings * kUlp * round_up_distance(furthest)) {
  for (int k = 0; k < 3; ++k) {
    from[static_cast<size_t>(k)] = static_cast<float>(start[k]);
    d[static_cast<size_t>(k)] = static_cast<float>(way[k]);
  }
}

float distance_at_least(const PatchLeaf& leaf, float steps_squared) {
  return (__builtin_sqrtf(steps_squared) - kError) * leaf.step * (1 - kSumError);
}

float round_up_distance(double distance) {
  return static_cast<float>(distance) * (1 + kUlp) + 1e-18F;
}

HAPTIC_WIDE LaneSet patches_near(const PatchNode& node, const PatchProbe& probe, float limit,
                                 Facing facing, PatchNode::Lanes& distance_squared) {
  Float8 box = splat(0), along = splat(0);
  for (size_t k = 0; k < 3; ++k) {
    const Float8 before = load<Float8>(node.lower[k]) - load<Float8>(probe.above[k]);
    const Float8 behind = load<Float8>(probe.below[k]) - load<Float8>(node.upper[k]);
    const Float8 outside = larger(larger(before, behind), splat(0));
    box += outside * outside;
    along += load<Float8>(node.axis[k]) * load<Float8>(probe.at[k]);
  }
  // how far the point is in front of the lowest of the slab, and behind the highest
  const Float8 slack = load<Float8>(probe.slack);
  const Float8 front = along - load<Float8>(node.low) + slack;
  const Float8 back = load<Float8>(node.high) - along + slack;
  const Float8 outside_slab = smaller(smaller(front, back), splat(0));
  const Float8 bound = larger(box, outside_slab * outside_slab);
  std::memcpy(distance_squared.data(), &bound, sizeof bound);

  Int8 dropped = bound > splat(limit * limit * (1 + kSumError));
  if (facing != Facing::kAny) {
    const Float8 cos_squared = load<Float8>(node.cos_squared);
    Float8 above = larger(front, back);
    if (facing == Facing::kFront) {
      // beyond 45° a pit seen from behind may count as seen from the front
      above = cos_squared > splat(0.5F) ? larger(front, splat(0)) : above;
    }
    dropped |= above * above < cos_squared * bound;
  }
  return lanes_of(~dropped);
}

HAPTIC_WIDE LaneSet triangles_near(const PatchLeaf& leaf, const PatchProbe& probe, bool nearest,
                                   float& limit, PatchNode::Lanes& steps_squared) {
  const float per_step = 1 / leaf.step;
  const Vec8 p = in_steps(leaf, probe.p_O);
  // |p − a − s ab − t ac|² is a quadratic in (s, t): least inside the triangle or on a side
  const Vec8 a = corner(leaf, 0);
  const Vec8 ab = corner(leaf, 1) - a, ac = corner(leaf, 2) - a, pa = a - p;
  const Float8 bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac);
  const Float8 pb = dot(ab, pa), pc = dot(ac, pa), pp = dot(pa, pa);
  const Float8 det = bb * cc - bc * bc;
  const Float8 s = bc * pc - cc * pb, t = bc * pb - bb * pc;
  const Int8 above_face = (s >= splat(0)) & (t >= splat(0)) & (s + t <= det);
  const Float8 to_face = pp + (pb * s + pc * t) / det;
  const Float8 across = bb - 2 * bc + cc;
  const Float8 to_sides = smaller(smaller(least_along(pp, pb, bb), least_along(pp, pc, cc)),
                                  least_along(pp + 2 * pb + bb, bc - bb + pc - pb, across));
  const Float8 d = above_face ? to_face : to_sides;
  const Float8 error = kCancelled * (pp + bb + cc);

  const Int8 is_thin = !(det > splat(0));
  const Int8 is_there = load<Int8>(leaf.triangle) != -1;
  if (nearest) {
    const Float8 at_most = is_there & ~is_thin ? d + error : splat(kFloatInfinity);
    const float surely = __builtin_sqrtf(least(larger(at_most, splat(0)))) + kError;
    limit = smaller(splat(surely * leaf.step * (1 + kSumError)), splat(limit))[0];
  }
  const float reach = per_step * limit * (1 + kSumError) + kError;
  const Int8 is_near = is_there & (is_thin | ~(d - error > splat(reach * reach)));
  const Float8 lower = is_thin ? splat(0) : larger(d - error, splat(0));
  std::memcpy(steps_squared.data(), &lower, sizeof lower);
  return lanes_of(is_near);
}

HAPTIC_WIDE LaneSet patches_on_way(const PatchNode& node, const WayProbe& way) {
  const Vec8 p = splat(way.from[0], way.from[1], way.from[2]);
  const Vec8 axis = load_rows(node.axis);
  const Float8 along = dot(axis, p);
  const Float8 front = along - load<Float8>(node.high), back = load<Float8>(node.low) - along;
  // from the point of the box next to the start, moved along the axis into the slab
  const Vec8 above = p - load_rows(node.lower), below = p - load_rows(node.upper);
  const auto outside = [](Float8 a, Float8 b) {
    return smaller(a, splat(0)) + larger(b, splat(0));
  };
  Vec8 u{outside(above.x, below.x), outside(above.y, below.y), outside(above.z, below.z)};
  const Float8 in_slab = dot(axis, u);
  u = u + (larger(front - in_slab, splat(0)) - larger(back + in_slab, splat(0))) * axis;
  // the slab bounds what is along the axis, the box what is across it
  const Float8 share = dot(axis, u);
  const Vec8 across = u - share * axis;
  const auto least_of = [](Float8 n, Float8 a, Float8 b) { return smaller(n * a, n * b); };
  const Float8 gap = larger(share, splat(0)) * front - smaller(share, splat(0)) * back +
                     least_of(across.x, above.x, below.x) + least_of(across.y, above.y, below.y) +
                     least_of(across.z, above.z, below.z);
  const Vec8 d = splat(way.d[0], way.d[1], way.d[2]);
  return lanes_of(~stays_off(u, gap, d, splat(way.radius + way.slack)));
}

HAPTIC_WIDE LaneSet triangles_on_way(const PatchLeaf& leaf, const WayProbe& way) {
  const float per_step = 1 / leaf.step;
  const Vec8 p = in_steps(leaf, way.from_O);
  const Vec8 a = corner(leaf, 0), b = corner(leaf, 1), c = corner(leaf, 2);
  const Vec8 ab = b - a, ac = c - a, pa = a - p;
  const Float8 bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac);
  const Float8 pb = dot(ab, pa), pc = dot(ac, pa);
  const Float8 det = bb * cc - bc * bc;
  // from the nearest point a + s ab + t ac: in the face, or on the nearest of the sides
  const Float8 s = (bc * pc - cc * pb) / det, t = (bc * pb - bb * pc) / det;
  const Int8 above_face = (s >= splat(0)) & (t >= splat(0)) & (s + t <= splat(1));
  const Float8 on_ab = least_at(pb, bb), on_ac = least_at(pc, cc);
  const Float8 across = bb - 2 * bc + cc, slope = bc - bb + pc - pb;
  const Float8 on_bc = least_at(slope, across);
  const Float8 d_ab = on_ab * (2 * pb + bb * on_ab), d_ac = on_ac * (2 * pc + cc * on_ac),
               d_bc = 2 * pb + bb + on_bc * (2 * slope + across * on_bc);
  const Int8 is_ab = (d_ab <= d_ac) & (d_ab <= d_bc), is_ac = d_ac <= d_bc;
  const Float8 side_s = is_ab ? on_ab : (is_ac ? splat(0) : 1 - on_bc);
  const Float8 side_t = is_ab ? splat(0) : (is_ac ? on_ac : on_bc);
  const Vec8 u =
      splat(0, 0, 0) - (pa + (above_face ? s : side_s) * ab + (above_face ? t : side_t) * ac);

  const Float8 gap = splat(0) - larger(larger(dot(u, pa), dot(u, b - p)), dot(u, c - p));
  const Vec8 d = splat(per_step * way.d[0], per_step * way.d[1], per_step * way.d[2]);
  const float reach = per_step * (way.radius + way.length * kSumError) * (1 + kSumError) + kError;
  const Int8 is_thin = !(det > splat(0));
  const Int8 is_there = load<Int8>(leaf.triangle) != -1;
  return lanes_of(is_there & (is_thin | ~stays_off(u, gap, d, splat(reach))));
}

}  // namespace haptic
