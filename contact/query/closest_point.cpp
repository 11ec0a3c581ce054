// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

/// Where on the triangle: corner or side `index`, or the face.
struct OnTriangle {
  Vec3 point;
  FeatureKind kind;
  uint32_t index = 0;
};

/// Closest point of the segment a b; side and corner numbers as in TriangleMesh.
OnTriangle closest_on_side(const Vec3& p, const std::array<Vec3, 3>& corners, uint32_t side) {
  const uint32_t next = (side + 1) % 3;
  const Vec3 ab = corners[next] - corners[side];
  const double along = dot(ab, p - corners[side]), length_squared = norm_squared(ab);
  if (!(along > 0)) return {corners[side], FeatureKind::kVertex, side};
  if (along >= length_squared) return {corners[next], FeatureKind::kVertex, next};
  return {corners[side] + (along / length_squared) * ab, FeatureKind::kEdge, side};
}

/// The nearest of the three sides: for triangles without area, where the regions mean nothing.
OnTriangle closest_on_border(const Vec3& p, const std::array<Vec3, 3>& corners) {
  OnTriangle best = closest_on_side(p, corners, 0);
  for (const uint32_t side : {1u, 2u}) {
    const OnTriangle other = closest_on_side(p, corners, side);
    if (norm_squared(p - other.point) < norm_squared(p - best.point)) best = other;
  }
  return best;
}

/// Voronoi regions of the corners, sides and face (Ericson 2005, §5.1.5).
OnTriangle closest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {a, FeatureKind::kVertex, 0};
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {b, FeatureKind::kVertex, 1};
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {c, FeatureKind::kVertex, 2};
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (!(va + vb + vc > 0)) return closest_on_border(p, corners);
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / (d1 - d3)) * ab, FeatureKind::kEdge, 0};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return {b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), FeatureKind::kEdge, 1};
  }
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / (d2 - d6)) * ac, FeatureKind::kEdge, 2};
  const double sum = va + vb + vc;
  return {a + (vb / sum) * ab + (vc / sum) * ac, FeatureKind::kFace, 0};
}

OnTriangle closest_on_triangle(const TriangleMesh& mesh, uint32_t triangle, const Vec3& p) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return closest_on_triangle(p, {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
}

ClosestPoint finish(const TriangleMesh& mesh, uint32_t triangle, const OnTriangle& on,
                    const Vec3& p_O) {
  ClosestPoint result;
  result.found = true;
  result.point_O = on.point;
  result.distance = norm(p_O - on.point);
  result.triangle = triangle;
  result.feature.kind = on.kind;
  switch (on.kind) {
    case FeatureKind::kVertex:
      result.feature.index = mesh.triangles[triangle][on.index];
      break;
    case FeatureKind::kEdge:
      result.feature.index = mesh.triangle_edges[triangle][on.index];
      break;
    default:
      result.feature.index = triangle;
  }
  // an open surface has no inside
  result.inside = mesh.closed && dot(p_O - on.point, pseudo_normal(mesh, result.feature)) < 0;
  return result;
}

/// Lower bound, but for kBoundSlack, of the squared distance to everything in the box.
double distance_squared(const CompactObb& compact, const Vec3& p_O) {
  const Obb box = compact.unpacked();
  const Vec3 q = box.R_BO * (p_O - box.centre_O);
  const double x = std::max(std::fabs(q.x) - box.half.x, 0.0);
  const double y = std::max(std::fabs(q.y) - box.half.y, 0.0);
  const double z = std::max(std::fabs(q.z) - box.half.z, 0.0);
  return x * x + y * y + z * z;
}

// a box this much too far may be so by rounding only
constexpr double kBoundSlack = kCompactSlack;

struct Waiting {
  double bound;
  uint32_t node;
};
using Stack = std::array<Waiting, kMaxTreeDepth + 1>;  // one sibling waits per level

/// The best triangle of a leaf so far: nearest, then lowest index.
struct Best {
  double distance_squared;
  uint32_t triangle = kNoFace;
  OnTriangle on{};
};

void visit_leaf(const MeshShape& shape, const ObbNode& leaf, const Vec3& p_O, Best& best) {
  for (const uint32_t triangle : shape.tree.order.subspan(leaf.first, leaf.count)) {
    const OnTriangle on = closest_on_triangle(shape.mesh, triangle, p_O);
    const double d = norm_squared(p_O - on.point);
    if (d < best.distance_squared || (d == best.distance_squared && triangle < best.triangle)) {
      best = {d, triangle, on};
    }
  }
}

}  // namespace

const Vec3& pseudo_normal(const TriangleMesh& mesh, const Feature& feature) {
  switch (feature.kind) {
    case FeatureKind::kVertex:
      return mesh.vertex_normals[feature.index];
    case FeatureKind::kEdge:
      return mesh.edge_normals[feature.index];
    default:
      return mesh.face_normals[feature.index];
  }
}

ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const Vec3& p_O) {
  return finish(mesh, triangle, closest_on_triangle(mesh, triangle, p_O), p_O);
}

ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance) {
  if (shape.tree.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  Best best{max_distance * max_distance};
  Stack stack;
  size_t waiting = 0;
  stack[waiting++] = {distance_squared(shape.tree.nodes[0].box, p_O), 0};
  while (waiting > 0) {
    const auto [bound, index] = stack[--waiting];
    if (bound > best.distance_squared * kBoundSlack) continue;
    const ObbNode& node = shape.tree.nodes[index];
    if (node.count > 0) {
      visit_leaf(shape, node, p_O, best);
      continue;
    }
    // the nearer child first: it tightens the bound for the other
    Waiting near{distance_squared(shape.tree.nodes[node.first].box, p_O), node.first};
    Waiting far{distance_squared(shape.tree.nodes[node.first + 1].box, p_O), node.first + 1u};
    if (far.bound < near.bound) std::swap(near, far);
    stack[waiting++] = far;
    stack[waiting++] = near;
  }
  if (best.triangle == kNoFace) return {};
  return finish(shape.mesh, best.triangle, best.on, p_O);
}

size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out) {
  if (shape.tree.nodes.empty() || !(radius > 0) || !is_finite(p_O)) return 0;
  const double radius_squared = radius * radius;
  size_t found = 0;
  std::array<uint32_t, kMaxTreeDepth + 1> stack;
  size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const ObbNode& node = shape.tree.nodes[stack[--waiting]];
    if (distance_squared(node.box, p_O) > radius_squared * kBoundSlack) continue;
    if (node.count == 0) {
      stack[waiting++] = node.first + 1;
      stack[waiting++] = node.first;
      continue;
    }
    for (const uint32_t triangle : shape.tree.order.subspan(node.first, node.count)) {
      const OnTriangle on = closest_on_triangle(shape.mesh, triangle, p_O);
      if (!(norm_squared(p_O - on.point) < radius_squared)) continue;
      if (found < out.size()) out[found] = finish(shape.mesh, triangle, on, p_O);
      ++found;
    }
  }
  return found;
}

}  // namespace haptic
