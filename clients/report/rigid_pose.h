// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/query/proximity/near_pairs.h"
#include "proto/math/qp.h"

namespace haptic {

/// The motion towards a target that a pose near a surface still allows, to first order.
struct WayLeft {
  Twist motion;           // towards the target, limited by the constraints; from the pose, in O
  double length = 0;      // |motion|_M expressed as a translation [m]
  size_t rows = 0;        // pairs of triangles within the band
  bool is_known = false;  // all pairs fitted, none intersects, and the program converged
};

/// Checks poses of a tool that must never enter an object, each one from scratch. It shares with
/// the detector only the meshes and the triangle-triangle distance: no state, no choice of
/// contacts.
class RigidPoseJudge {
 public:
  struct Springs {
    double translational = 800, rotational = 2;  // diagonal of M [N/m], [N·m/rad]
  };
  /// Keeps views of the shapes, which must outlive it.
  RigidPoseJudge(const MeshShape& object, const MeshShape& tool, const Springs& springs);

  /// Whether the surfaces intersect (exact test) or one closed body contains the other.
  bool is_entered(const Pose& X_OT) const;

  /// argmin ½ (a − a_u)ᵀ M (a − a_u) s.t. J_k a ≥ min(margin − gap_k, 0) for every pair of
  /// triangles no further apart than `band` [m]; a_u is the motion to led_O. If the result is far
  /// from zero, something other than contact held the tool back.
  WayLeft way_left(const Pose& X_OT, const Pose& led_O, double margin, double band);

  /// |a|_M expressed as a translation [m].
  double length_of(const Twist& motion) const;

 private:
  MeshShape object_, tool_;
  std::vector<Vec3> object_points_, tool_points_;  // one point of each shell
  Springs springs_;
  MotionMetric metric_;
  std::vector<NearPair> near_;
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
