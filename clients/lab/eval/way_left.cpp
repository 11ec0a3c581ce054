// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/way_left.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr size_t kRoom = 50'000;  // capacity in pairs of near triangles

}  // namespace

WayLeftJudge::WayLeftJudge(const MeshShape& object, const MeshShape& tool, const Springs& springs)
    : RigidPoseJudge(object, tool),
      springs_(springs),
      metric_(factor_metric(spring_matrix(springs.translational, springs.rotational))),
      near_(kRoom) {}

double WayLeftJudge::length_of(const Twist& motion) const {
  return spring_length(motion, springs_.translational, springs_.rotational);
}

WayLeft WayLeftJudge::way_left(const Pose& X_OT, const Pose& led_O, double margin, double band) {
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
  const ConstrainedMotion found = least_constraint(metric_, way_between(X_OT, led_O), rows_);
  left.is_known &= found.converged;
  left.motion = found.a;
  left.length = length_of(found.a);
  return left;
}

}  // namespace haptic
