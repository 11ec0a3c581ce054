// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval_rigid_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/query/closest_point.h"
#include "contact/query/triangle_pairs.h"

namespace haptic {
namespace {

constexpr size_t kRoom = 50'000;  // of pairs

bool holds(const MeshShape& outer, const MeshShape& inner, const Pose& X_outer_inner) {
  if (!outer.mesh.closed || inner.mesh.vertices.empty()) return false;
  const double any_distance = std::numeric_limits<double>::infinity();
  return closest_point(outer, X_outer_inner * inner.mesh.vertices[0], any_distance).inside;
}

}  // namespace

RigidPoseJudge::RigidPoseJudge(const MeshShape& object, const MeshShape& tool,
                               const Springs& springs)
    : object_(object), tool_(tool), springs_(springs), near_(kRoom) {
  Mat6 M;
  add_block(M, 0, 0, springs.translational * Mat3{});
  add_block(M, 3, 3, springs.rotational * Mat3{});
  metric_ = factor_metric(M);
}

bool RigidPoseJudge::is_entered(const Pose& X_OT) const {
  return triangle_pairs(object_, tool_, X_OT, {}) > 0 || holds(object_, tool_, X_OT) ||
         holds(tool_, object_, inverse(X_OT));
}

double RigidPoseJudge::length_of(const Twist& motion) const {
  const double turn = springs_.rotational * norm_squared(motion.w) / springs_.translational;
  return std::sqrt(norm_squared(motion.v) + turn);
}

WayLeft RigidPoseJudge::way_left(const Pose& X_OT, const Pose& led_O, double margin, double band) {
  WayLeft left;
  left.rows = near_pairs(object_, tool_, X_OT, band, near_);
  left.is_known = left.rows <= near_.size();
  rows_.clear();
  for (size_t k = 0; k < std::min(left.rows, near_.size()); ++k) {
    const TriangleDistance& at = near_[k].at;
    left.is_known &= at.distance > 0;
    if (!(at.distance > 0)) continue;
    const Vec3 normal_O = (at.point_b - at.point_a) / at.distance;
    rows_.push_back(contact_row(at.point_b - X_OT.p, normal_O, at.distance - margin, 0));
  }
  const Twist way{led_O.p - X_OT.p, to_rotation_vector(led_O.q * conjugate(X_OT.q))};
  const ConstrainedMotion found = least_constraint(metric_, way, rows_);
  left.is_known &= found.converged;
  left.motion = found.a;
  left.length = length_of(found.a);
  return left;
}

}  // namespace haptic
