// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/rigid_pose.h"
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

/// Judges where a rigid tool could still go, each pose from scratch.
class WayLeftJudge : public RigidPoseJudge {
 public:
  struct Springs {
    double translational = 800, rotational = 2;  // diagonal of M [N/m], [N·m/rad]
  };
  /// Keeps views of the shapes, which must outlive it.
  WayLeftJudge(const MeshShape& object, const MeshShape& tool, const Springs& springs);

  /// argmin ½ (a − a_u)ᵀ M (a − a_u) s.t. J_k a ≥ min(margin − gap_k, 0) for every pair of
  /// triangles no further apart than `band` [m]; a_u is the motion to led_O. If the result is far
  /// from zero, something other than contact held the tool back.
  WayLeft way_left(const Pose& X_OT, const Pose& led_O, double margin, double band);

  /// |a|_M expressed as a translation [m].
  double length_of(const Twist& motion) const;

 private:
  Springs springs_;
  MotionMetric metric_;
  std::vector<NearPair> near_;
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
