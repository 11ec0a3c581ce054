// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/query/patch_probe.h"

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

OnTriangle closest_on_triangle(const TriangleMesh& mesh, const Triangle& corners, const Vec3& p) {
  const auto& [a, b, c] = corners;
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

struct Waiting {
  float distance_squared;  // at least
  uint32_t child;
  uint32_t node;  // which holds it
};

/// Patches still to be looked at, the nearest of a node last.
struct Waitlist {
  std::array<Waiting, kMaxPatchDepth * kPatchLanes> patches;
  size_t size = 0;

  void add(const PatchProbe::Bounds& bounds, const PatchNode& node, uint32_t index) {
    const size_t first = size;
    for (size_t lane = 0; lane < kPatchLanes; ++lane) {
      if (bounds.kept[lane] == 0) continue;
      const Waiting next{bounds.distance_squared[lane], node.child[lane], index};
      size_t at = size++;
      for (; at > first && patches[at - 1].distance_squared < next.distance_squared; --at) {
        patches[at] = patches[at - 1];
      }
      patches[at] = next;
    }
  }
};

/// The search for the nearest triangle; among equally near ones for the lowest index.
class NearestSearch {
 public:
  NearestSearch(const MeshShape& shape, const Vec3& p_O, double max_distance)
      : shape_(shape), p_O_(p_O), probe_(p_O) {
    set_best(max_distance * max_distance);
  }

  /// Everything below a node.
  void search(uint32_t node) {
    open(node, kPatchLanes);
    drain();
  }

  /// Everything below the parent of a node but what was searched: the node itself. Returns the
  /// parent.
  uint32_t search_around(uint32_t node) {
    const uint32_t parent = shape_.patches.nodes[node].parent;
    open(parent / kPatchLanes, parent % kPatchLanes);
    drain();
    return parent / kPatchLanes;
  }

  bool found() const { return triangle_ != kNoFace; }
  uint32_t node() const { return node_; }
  ClosestPoint result() const { return finish(shape_.mesh, triangle_, on_, p_O_); }

 private:
  void set_best(double distance_squared) {
    best_ = distance_squared;
    limit_ = PatchProbe::limit(distance_squared);
  }

  void open(uint32_t index, size_t but_lane) {
    const PatchNode& node = shape_.patches.nodes[index];
    PatchProbe::Bounds bounds = probe_.bounds<Facing::kEitherSide>(node, limit_);
    if (but_lane < kPatchLanes) bounds.kept[but_lane] = 0;
    waiting_.add(bounds, node, index);
  }

  void drain() {
    while (waiting_.size > 0) {
      const Waiting next = waiting_.patches[--waiting_.size];
      if (next.distance_squared > limit_ || next.child == kNoPatch) continue;
      if ((next.child & kPatchLeaf) == 0) {
        open(next.child, kPatchLanes);
      } else {
        visit(shape_.patches.leaves[next.child & ~kPatchLeaf], next.node);
      }
    }
  }

  void visit(const PatchLeaf& leaf, uint32_t node) {
    for (size_t i = 0; i < kPatchLanes && leaf.triangle[i] != kNoFace; ++i) {
      const OnTriangle on = closest_on_triangle(shape_.mesh, leaf.corners[i], p_O_);
      const double d = norm_squared(p_O_ - on.point);
      if (d > best_ || (d == best_ && leaf.triangle[i] > triangle_)) continue;
      set_best(d);
      triangle_ = leaf.triangle[i];
      on_ = on;
      node_ = node;
    }
  }

  const MeshShape& shape_;
  Vec3 p_O_;
  PatchProbe probe_;
  double best_ = 0;  // squared
  float limit_ = 0;
  uint32_t triangle_ = kNoFace;
  uint32_t node_ = 0;
  OnTriangle on_{};
  Waitlist waiting_;
};

/// The four patches of a node together: its box.
void box_of(const PatchNode& node, Vec3& lower, Vec3& upper) {
  for (int k = 0; k < 3; ++k) {
    const auto row = static_cast<size_t>(k);
    lower[k] = upper[k] = static_cast<double>(node.lower[row][0]);
    for (size_t lane = 0; lane < kPatchLanes; ++lane) {
      if (node.child[lane] == kNoPatch) continue;
      lower[k] = std::min(lower[k], static_cast<double>(node.lower[row][lane]));
      upper[k] = std::max(upper[k], static_cast<double>(node.upper[row][lane]));
    }
  }
}

bool holds(const PatchNode& node, const Vec3& q) {
  Vec3 lower, upper;
  box_of(node, lower, upper);
  return q.x >= lower.x && q.y >= lower.y && q.z >= lower.z && q.x <= upper.x && q.y <= upper.y &&
         q.z <= upper.z;
}

/// Where to begin: the smallest node above the witness that holds where the closest point would be
/// if it moved as p did; the root after a jump.
uint32_t first_node(const PatchTree& patches, const Vec3& p_O, const ClosestWitness& witness) {
  const Vec3 moved_O = p_O - witness.p_O;
  if (!(norm_squared(moved_O) < witness.reach * witness.reach)) return 0;
  if (witness.node >= patches.nodes.size()) return 0;
  const Vec3 guess_O = witness.point_O + moved_O;
  uint32_t node = witness.node;
  while (node != 0 && !holds(patches.nodes[node], guess_O)) {
    node = patches.nodes[node].parent / static_cast<uint32_t>(kPatchLanes);
  }
  return node;
}

void remember(const PatchTree& patches, const Vec3& p_O, const ClosestPoint& closest, uint32_t node,
              ClosestWitness& witness) {
  constexpr double kReach = 8;  // node sizes
  if (node != witness.node || !(witness.reach > 0)) {
    Vec3 lower, upper;
    box_of(patches.nodes[node], lower, upper);
    witness.reach = kReach * norm(upper - lower);
  }
  witness.p_O = p_O;
  witness.point_O = closest.point_O;
  witness.node = node;
}

/// Appends what triangles_within and triangles_facing are about, as far as there is room.
template <Facing facing>
size_t collect(const MeshShape& shape, const Vec3& p_O, double radius,
               std::span<ClosestPoint> out) {
  if (shape.patches.nodes.empty() || !(radius > 0) || !is_finite(p_O)) return 0;
  const double radius_squared = radius * radius;
  const PatchProbe probe(p_O);
  const float limit = PatchProbe::limit(radius_squared);
  size_t found = 0;
  std::array<uint32_t, kMaxPatchDepth * kPatchLanes> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = 0;
  while (n_waiting > 0) {
    const uint32_t child = waiting[--n_waiting];
    if ((child & kPatchLeaf) == 0) {
      const PatchNode& node = shape.patches.nodes[child];
      const auto bounds = probe.bounds<facing>(node, limit);
      for (size_t lane = kPatchLanes; lane-- > 0;) {
        if (bounds.kept[lane] != 0 && node.child[lane] != kNoPatch) {
          waiting[n_waiting++] = node.child[lane];
        }
      }
      continue;
    }
    const PatchLeaf& leaf = shape.patches.leaves[child & ~kPatchLeaf];
    for (size_t i = 0; i < kPatchLanes && leaf.triangle[i] != kNoFace; ++i) {
      const OnTriangle on = closest_on_triangle(shape.mesh, leaf.corners[i], p_O);
      if (!(norm_squared(p_O - on.point) < radius_squared)) continue;
      if (found < out.size()) out[found] = finish(shape.mesh, leaf.triangle[i], on, p_O);
      ++found;
    }
  }
  return found;
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
  return finish(mesh, triangle, closest_on_triangle(mesh, mesh.triangles[triangle], p_O), p_O);
}

ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  NearestSearch nearest(shape, p_O, max_distance);
  nearest.search(0);
  return nearest.found() ? nearest.result() : ClosestPoint{};
}

ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                           ClosestWitness& witness) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  NearestSearch nearest(shape, p_O, max_distance);
  uint32_t node = first_node(shape.patches, p_O, witness);
  nearest.search(node);
  // a bound is known: what lies around it is soon done with
  while (node != 0) node = nearest.search_around(node);
  if (!nearest.found()) return {};
  const ClosestPoint closest = nearest.result();
  remember(shape.patches, p_O, closest, nearest.node(), witness);
  return closest;
}

size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out) {
  return collect<Facing::kAny>(shape, p_O, radius, out);
}

size_t triangles_facing(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out) {
  return collect<Facing::kFront>(shape, p_O, radius, out);
}

}  // namespace haptic
