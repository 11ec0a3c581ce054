// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact/query/point/segment_entry.h"
#include "contact/query/simd/lanes.h"
#include "contact/shape/mesh/box.h"
#include "contact/shape/tree/obb_tree.h"
#include "proto/math/assert.h"

namespace haptic {

/// The view along the segment: its dominant axis becomes z, and a shear maps it onto the z axis
/// (Woop, Benthin, Wald 2013). Each vertex is rounded once, the same for all its triangles, so
/// everything after is exact geometry of one slightly perturbed mesh: no cracks.
class SegmentView {
 public:
  /// False for a zero-length (or not finite) segment, which hits nothing.
  bool look_along(const Vec3& from_O, const Vec3& d_O) {
    const double x = std::fabs(d_O.x), y = std::fabs(d_O.y), z = std::fabs(d_O.z);
    if (!(x + y + z > 0 && x + y + z <= std::numeric_limits<double>::max())) return false;
    z_ = longest_axis({x, y, z});
    x_ = z_ == 2 ? 0 : z_ + 1;
    y_ = z_ == 0 ? 2 : z_ - 1;
    from_xy_ = Pair{at(from_O, x_), at(from_O, y_)};
    from_z_ = at(from_O, z_);
    t_per_z_ = 1 / at(d_O, z_);
    xy_per_z_ = Pair{at(d_O, x_), at(d_O, y_)} / at(d_O, z_);
    facing_ = t_per_z_ > 0 ? 1 : -1;
    return true;
  }

  /// Whether the segment enters the triangle through its front side, and where.
  bool enters(const Vec3& a_O, const Vec3& b_O, const Vec3& c_O, double& t) const {
    const Projected a = project(a_O), b = project(b_O), c = project(c_O);
    const double u = facing_ * edge_area(b.xy, c.xy), v = facing_ * edge_area(c.xy, a.xy),
                 w = facing_ * edge_area(a.xy, b.xy);
    const double area = u + v + w;
    // on an edge both neighbours are hit, never none; one branch, since all of these are rare
    if ((u > 0) | (v > 0) | (w > 0) | (area == 0)) return false;
    t = (u * (a.z * t_per_z_) + v * (b.z * t_per_z_) + w * (c.z * t_per_z_)) / area;
    return t >= 0 && t <= 1;
  }

  /// Takes the triangle where the segment enters it before `best`; ties go to the lower index.
  void test(const TriangleMesh& mesh, uint32_t triangle, SegmentHit& best) const {
    const auto& [a, b, c] = mesh.triangles[triangle];
    double t = 0;
    if (!enters(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], t)) return;
    if (best.hit && (t > best.t || (t == best.t && triangle >= best.triangle))) return;
    best = {true, t, triangle};
  }

 private:
  struct Projected {
    Pair xy;   // across the segment
    double z;  // along its axis
  };

  static double at(const Vec3& v, int axis) { return (&v.x)[axis]; }

  Projected project(const Vec3& vertex_O) const {
    const double z = at(vertex_O, z_) - from_z_;
    return {(Pair{at(vertex_O, x_), at(vertex_O, y_)} - from_xy_) - xy_per_z_ * z, z};
  }

  /// Twice the signed area of (segment, a, b): the edge function. Its sign is exact and exactly
  /// antisymmetric: rounding is monotone, and where both products round to the same number their
  /// remainders decide.
  static double edge_area(Pair a, Pair b) {
    const Pair products = a * __builtin_shufflevector(b, b, 1, 0);
    const double p = products[0], q = products[1];
    return p != q ? p - q : std::fma(a[0], b[1], -p) - std::fma(a[1], b[0], -q);
  }

  int x_, y_, z_;  // axes in cyclic order, the dominant one last
  Pair from_xy_, xy_per_z_;
  double from_z_, t_per_z_;
  double facing_;  // −1 if the segment runs against its axis: makes front areas negative for both
};

/// A segment prepared for many boxes, in float; conservative: rejects only boxes that the segment
/// misses regardless of rounding.
class SegmentProbe {
 public:
  /// `reach`: largest coordinate of the segment and of the boxes.
  SegmentProbe(const Vec3& from_O, const Vec3& d_O, double reach)
      : slack_(static_cast<float>(kSlack * reach)) {
    HAPTIC_ASSERT(!(reach < 0));
    cut(from_O, d_O, 1);
  }

  /// Restricts it to the part up to fraction t of from_O → from_O + d_O.
  void cut(const Vec3& from_O, const Vec3& d_O, double t) {
    const Vec3 half_O = (0.5 * t) * d_O, middle_O = from_O + half_O;
    middle_ = {static_cast<float>(middle_O.x), static_cast<float>(middle_O.y),
               static_cast<float>(middle_O.z)};
    half_ = {static_cast<float>(half_O.x), static_cast<float>(half_O.y),
             static_cast<float>(half_O.z)};
    cross_slack_ = 3 * slack_ * (std::fabs(half_[0]) + std::fabs(half_[1]) + std::fabs(half_[2]));
  }

  /// Line–OBB test of H-Collide (Gregory, Lin, Gottschalk, Taylor 2000): three box axes, then three
  /// cross products, each three at a time.
  bool meets(const CompactObb& box) const {
    const float* c = box.columns_BO.data();
    const Lanes x = load_lanes<Lanes>(c), y = load_lanes<Lanes>(c + 3),
                z = load_lanes<Lanes>(c + 6);
    const Lanes m = x * (middle_[0] - box.centre_O[0]) + y * (middle_[1] - box.centre_O[1]) +
                    z * (middle_[2] - box.centre_O[2]);
    const Lanes w = x * half_[0] + y * half_[1] + z * half_[2];
    const Lanes h = magnitude(w), t = load_lanes<Lanes>(box.half.data()) + slack_;
    const Lanes normals = magnitude(m * next(w) - next(m) * w);
    // the fourth lane holds the next member of the node: computed, but unused
    const IntLanes apart =
        (magnitude(m) > h + t) | (normals > t * next(h) + next(t) * h + cross_slack_);
    return (apart[0] | apart[1] | apart[2]) == 0;
  }

  /// Whether the centre of box a comes before that of b along the segment.
  bool reaches_first(const CompactObb& a, const CompactObb& b) const {
    float along = 0;
    for (size_t i = 0; i < 3; ++i) along += half_[i] * (b.centre_O[i] - a.centre_O[i]);
    return along > 0;
  }

 private:
  // 2⁻²⁴ for each rounding of a coordinate, its rotation and its shear, doubled
  static constexpr double kSlack = 36 * 0x1p-24;

  /// y z x
  static Lanes next(Lanes v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); }

  std::array<float, 3> middle_{}, half_{};
  float slack_, cross_slack_ = 0;
};

}  // namespace haptic
