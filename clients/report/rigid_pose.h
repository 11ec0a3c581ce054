// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/query/proximity/near_pairs.h"
#include "proto/math/qp.h"

namespace haptic {

/// What a pose near a surface still allows, to first order.
struct WayLeft {
  Twist motion;           // towards where it is led, as far as no row forbids; from the pose, in O
  double length = 0;      // |motion|_M as a translation [m]
  size_t rows = 0;        // pairs of triangles within the band
  bool is_known = false;  // all of them fitted, none meets, and the program was solved
};

/// Judges poses of a tool that must never enter an object, each by itself and from scratch: with
/// who found them it shares the meshes and the distance of two triangles, no memory and no choice
/// of contacts.
class RigidPoseJudge {
 public:
  struct Springs {
    double translational = 800, rotational = 2;  // of M [N/m], [N·m/rad]
  };
  /// Views; the shapes must outlive it.
  RigidPoseJudge(const MeshShape& object, const MeshShape& tool, const Springs& springs);

  /// Whether the surfaces meet, exactly, or one closed body holds the other.
  bool is_entered(const Pose& X_OT) const;

  /// argmin ½ (a − a_u)ᵀ M (a − a_u) s.t. J_k a ≥ min(margin − gap_k, 0) for each pair of triangles
  /// that is no further apart than the band [m], a_u the way to led_O: where it is far from zero,
  /// what held the tool back was no contact.
  WayLeft way_left(const Pose& X_OT, const Pose& led_O, double margin, double band);

  /// |a|_M as a translation [m].
  double length_of(const Twist& motion) const;

 private:
  MeshShape object_, tool_;
  std::vector<Vec3> object_points_, tool_points_;  // one of each shell
  Springs springs_;
  MotionMetric metric_;
  std::vector<NearPair> near_;
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
