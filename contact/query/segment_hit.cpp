// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/segment_hit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

// slack of the box test, of the largest coordinate in play: ~70 roundings
constexpr double kRelativeSlack = 1.6e-14;

struct ProjectedVertex {
  double x, y;  // across the segment
  double t;     // along it: 0 at from, 1 at to
};

/// The segment looked at along itself: its dominant axis is z, and a shear takes it onto the z axis
/// (Woop, Benthin, Wald 2013). Each vertex is rounded once, the same for all its triangles, so what
/// follows is exact geometry on one slightly moved mesh: no cracks.
struct SegmentView {
  Vec3 from_O;
  int axis = 0;  // the dominant one
  double x_per_z = 0, y_per_z = 0;
  double t_per_z = 0;
  double facing = 1;  // mirrors x where the segment runs down its axis: front areas are negative
};

/// Coordinates turned cyclically so that `axis` comes last.
Vec3 turned(const Vec3& v, int axis) {
  switch (axis) {
    case 0:
      return {v.y, v.z, v.x};
    case 1:
      return {v.z, v.x, v.y};
    default:
      return v;
  }
}

/// False for a zero-length (or not finite) segment.
bool look_along(const Vec3& from_O, const Vec3& to_O, SegmentView& view) {
  const Vec3 d = to_O - from_O;
  const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
  view.from_O = from_O;
  view.axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  const Vec3 e = turned(d, view.axis);
  if (!(e.z != 0) || !is_finite(d)) return false;
  view.x_per_z = e.x / e.z;
  view.y_per_z = e.y / e.z;
  view.t_per_z = 1 / e.z;
  view.facing = e.z > 0 ? 1 : -1;
  return true;
}

ProjectedVertex project(const SegmentView& view, const Vec3& vertex_O) {
  const Vec3 r = turned(vertex_O - view.from_O, view.axis);
  return {view.facing * (r.x - view.x_per_z * r.z), r.y - view.y_per_z * r.z, r.z * view.t_per_z};
}

/// Twice the signed area of (segment, a, b): the edge volume over the length of the segment. The
/// sign is exact and exactly antisymmetric: rounding is monotone, and where the two products round
/// to the same number their remainders decide.
double edge_area(const ProjectedVertex& a, const ProjectedVertex& b) {
  const double p = a.x * b.y, q = a.y * b.x;
  return p != q ? p - q : std::fma(a.x, b.y, -p) - std::fma(a.y, b.x, -q);
}

bool enters(const SegmentView& view, const Vec3& a_O, const Vec3& b_O, const Vec3& c_O, double& t) {
  const ProjectedVertex a = project(view, a_O), b = project(view, b_O), c = project(view, c_O);
  const double u = edge_area(b, c), v = edge_area(c, a), w = edge_area(a, b);
  // on an edge both neighbours are hit, never none
  if (u > 0 || v > 0 || w > 0) return false;
  const double area = u + v + w;
  if (area == 0) return false;
  t = (u * a.t + v * b.t + w * c.t) / area;
  return t >= 0 && t <= 1;
}

/// Segment given by its middle and half vector.
struct HalfSegment {
  Vec3 middle_O;
  Vec3 half_O;
};

/// Line–OBB test of H-Collide: three box axes, then three cross products. The slack keeps rounding
/// on the safe side.
bool meets_box(const HalfSegment& segment, const Obb& box, double slack, double half_length) {
  const Vec3 m = box.R_BO * (segment.middle_O - box.centre_O);
  const Vec3 w = box.R_BO * segment.half_O;
  const Vec3 h{std::fabs(w.x), std::fabs(w.y), std::fabs(w.z)};
  const Vec3& t = box.half;
  if (std::fabs(m.x) > h.x + t.x + slack) return false;
  if (std::fabs(m.y) > h.y + t.y + slack) return false;
  if (std::fabs(m.z) > h.z + t.z + slack) return false;
  const double cross_slack = slack * half_length;
  return std::fabs(m.y * w.z - m.z * w.y) <= t.y * h.z + t.z * h.y + cross_slack &&
         std::fabs(m.x * w.z - m.z * w.x) <= t.x * h.z + t.z * h.x + cross_slack &&
         std::fabs(m.x * w.y - m.y * w.x) <= t.x * h.y + t.y * h.x + cross_slack;
}

double largest_coordinate(const Vec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// The part of the segment up to fraction t.
HalfSegment up_to(const Vec3& from_O, const Vec3& d_O, double t) {
  const Vec3 half_O = (0.5 * t) * d_O;
  return {from_O + half_O, half_O};
}

void visit_leaf(const MeshShape& shape, const ObbNode& leaf, const SegmentView& view,
                SegmentHit& best) {
  for (const uint32_t triangle : shape.tree.order.subspan(leaf.first, leaf.count)) {
    const auto& [a, b, c] = shape.mesh.triangles[triangle];
    const auto& vertices = shape.mesh.vertices;
    double t = 0;
    if (!enters(view, vertices[a], vertices[b], vertices[c], t)) continue;
    if (!best.hit || t < best.t || (t == best.t && triangle < best.triangle)) {
      best = {true, t, triangle};
    }
  }
}

}  // namespace

bool segment_meets_box(const Vec3& from_O, const Vec3& to_O, const Obb& box) {
  const HalfSegment segment = up_to(from_O, to_O - from_O, 1);
  return meets_box(segment, box, 0, norm(segment.half_O));
}

bool segment_enters_triangle(const Vec3& from_O, const Vec3& to_O, const Vec3& a, const Vec3& b,
                             const Vec3& c, double& t) {
  SegmentView view;
  return look_along(from_O, to_O, view) && enters(view, a, b, c, t);
}

SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  SegmentHit best;
  SegmentView view;
  if (shape.tree.nodes.empty() || !look_along(from_O, to_O, view)) return best;
  const Vec3 d_O = to_O - from_O;
  const double slack =
      kRelativeSlack *
      std::max({largest_coordinate(from_O), largest_coordinate(to_O),
                largest_coordinate(shape.mesh.lower), largest_coordinate(shape.mesh.upper)});
  HalfSegment segment = up_to(from_O, d_O, 1);
  const double half_length = norm(segment.half_O);
  // one sibling waits per level
  std::array<uint32_t, kMaxTreeDepth + 1> stack;
  size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const ObbNode& node = shape.tree.nodes[stack[--waiting]];
    if (!meets_box(segment, node.box, slack, half_length)) continue;
    if (node.count > 0) {
      visit_leaf(shape, node, view, best);
      // what lies behind the best hit is of no interest any more
      if (best.hit) segment = up_to(from_O, d_O, best.t);
      continue;
    }
    const Vec3 apart_O =
        shape.tree.nodes[node.first + 1].box.centre_O - shape.tree.nodes[node.first].box.centre_O;
    const uint32_t near = dot(apart_O, d_O) >= 0 ? 0 : 1;
    stack[waiting++] = node.first + 1 - near;
    stack[waiting++] = node.first + near;
  }
  return best;
}

}  // namespace haptic
