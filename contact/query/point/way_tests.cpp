// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/way_tests.h"

#include "contact/query/point/patch_lanes.h"
#include "contact/query/simd/lanes8.h"
#include "proto/math/assert.h"

namespace haptic {

using namespace lanes8;

namespace {

constexpr float kWayRoundings = 32;  // ulps of the largest coordinate that the tests may be off

HAPTIC_INLINE Vec8 splat3(float x, float y, float z) {
  return {splat(x), splat(y), splat(z)};
}
HAPTIC_INLINE Vec8 load_rows(const std::array<PatchNode::Lanes, 3>& rows) {
  return {load<Float8>(rows[0]), load<Float8>(rows[1]), load<Float8>(rows[2])};
}

/// Whether a plane normal to u separates a moving sphere of radius `reach` from something at
/// distance `gap` along u (times |u|) from its start, during the whole displacement d.
HAPTIC_INLINE Int8 stays_off(const Vec8& u, Float8 gap, const Vec8& d, Float8 reach) {
  const Float8 least = gap + smaller(dot(u, d), splat(0));
  return (least > splat(0)) & (least * least > dot(u, u) * reach * reach);
}

}  // namespace

WayProbe::WayProbe(const Vec3& start, const Vec3& way, double r, double furthest)
    : from_O(start),
      length(round_up_distance(norm(way))),
      radius(round_up_distance(r) * (1 + kSumError)),
      slack(kWayRoundings * lanes8::kUlp * round_up_distance(furthest)) {
  HAPTIC_ASSERT(r >= 0 && furthest >= 0);
  for (int k = 0; k < 3; ++k) {
    from[static_cast<size_t>(k)] = static_cast<float>(start[k]);
    d[static_cast<size_t>(k)] = static_cast<float>(way[k]);
  }
}

HAPTIC_WIDE LaneSet patches_on_way(const PatchNode& node, const WayProbe& way) {
  const Vec8 p = splat3(way.from[0], way.from[1], way.from[2]);
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
  const Vec8 d = splat3(way.d[0], way.d[1], way.d[2]);
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
      splat3(0, 0, 0) - (pa + (above_face ? s : side_s) * ab + (above_face ? t : side_t) * ac);

  const Float8 gap = splat(0) - larger(larger(dot(u, pa), dot(u, b - p)), dot(u, c - p));
  const Vec8 d = splat3(per_step * way.d[0], per_step * way.d[1], per_step * way.d[2]);
  const float reach = per_step * (way.radius + way.length * kSumError) * (1 + kSumError) + kError;
  const Int8 is_thin = !(det > splat(0));
  const Int8 is_there = load<Int8>(leaf.triangle) != -1;
  return lanes_of(is_there & (is_thin | ~stays_off(u, gap, d, splat(reach))));
}

}  // namespace haptic
