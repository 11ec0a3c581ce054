// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clients/report/report.h"
#include "clients/report/rigid_pose.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Parameters of the check.
struct RigidJudgeOptions {
  RigidPoseJudge::Springs springs;  // of the coupling
  double margin = 0;                // distance the tool keeps from surfaces [m]
  double dt = 1e-3;                 // [s]
  double blend_time = 3e-3;         // in which the servo fades contacts in and out [s]
  // no mass, no damper: the force is due to contacts only, and cone, steps and jams have goals
  bool is_massless = true;
};

/// Checks in every tick a session of a tool that must never enter its object, which is fixed in W.
/// The norm of a wrench is |F| = √(|f|² + |τ|² k_T/k_R), k_T times the distance between hand and
/// proxy in the coupling's metric.
///  - Inside: each verified pose, by exact intersection.
///  - Jams: the force exceeds the one by all pairs of triangles within the hand's reach by 0.1 N
///    while the proxy moves less than a tenth of the hand's motion; or a verified pose has moved
///    less than a margin although ten margins of feasible motion are left.
///  - Falls (tunnelling): there is no force, although all pairs of triangles within reach of the
///    hand give more than 0.1 N, and the tool would be inside at one of eight poses on the way to
///    the hand, not counting the last part (0.1 N, or one tick of motion).
///  - Cone: the part of the force that no non-negative combination of the contacts explains,
///    relative to the force; fading contacts count.
///  - Steps: |ΔF| minus the part due to the hand's motion and the fading of contacts,
///    k_T |Δhand| + dt/blend_time (F_out + F_in). F_out is the largest force of this tick and the
///    blend_time before it, F_in that of all contacts of the set on the last proxy at once.
class RigidJudge {
 public:
  /// Keeps views of the shapes, which must outlive it.
  RigidJudge(const MeshShape& object, const MeshShape& tool, const RigidJudgeOptions& options);

  /// `set` as used by the tick, null before the first.
  void add(const ServoFrame& frame, const ContactSet* set);

  std::vector<Row> rows(const std::string& case_name) const;

  struct Found {
    uint64_t ticks = 0, felt = 0, not_finite = 0;
    uint64_t poses = 0, inside = 0, unsettled = 0, placed_anew = 0;
    uint64_t held = 0, jammed_poses = 0, jammed_ticks = 0, fallen = 0, unknown = 0;
    double largest_force = 0, off_cone = 0;    // [N], of the force
    double largest_step = 0, beyond_step = 0;  // [N]
  };
  const Found& found() const { return found_; }

 private:
  static constexpr size_t kSetsKept = 8;
  struct Push {
    Vec3 tool_point_T, normal_W, arm_W;  // arm_W: at the time of the set
  };
  double size_of(const Wrench& F_W) const;
  void judge_pose(const ContactSet& set);
  void judge_cone(const ServoFrame& frame, const ContactSet& set);
  double let_in(const ContactSet& set);
  void judge_step(const ServoFrame& frame, const ContactSet& set);
  bool is_passed(const Pose& X_WG, const Twist& way, const Twist& hand) const;
  void judge_force(const ServoFrame& frame, const ContactSet& set);

  RigidJudgeOptions options_;
  RigidPoseJudge poses_;
  MotionMetric metric_;
  std::vector<double> fading_;  // forces [N] of the ticks whose contacts may still be fading out
  Found found_;
  std::array<std::vector<Push>, kSetsKept> pushes_;  // of the last sets
  bool has_set_ = false, has_frame_ = false;
  uint64_t last_seq_ = 0;
  Pose last_X_WG_;
  ServoFrame last_{};
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
