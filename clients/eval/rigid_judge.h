// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clients/report/report.h"
#include "clients/report/rigid_pose.h"
#include "proto/wire/wire.h"

namespace haptic {

/// What is judged, and against what.
struct RigidJudgeOptions {
  RigidPoseJudge::Springs springs;  // of the coupling
  double margin = 0;                // that the tool keeps to surfaces [m]
  double dt = 1e-3;                 // [s]
  double blend_time = 3e-3;         // in which the servo lets contacts in and out [s]
  // the hand feels contacts alone, no mass and no damper: cone, steps and jams have goals
  bool is_massless = true;
};

/// Watches a session of a tool that must never enter its object, which lies still in W, tick by
/// tick. |F| of a wrench is √(|f|² + |τ|² k_T/k_R), k_T times the distance in the coupling's metric
/// between hand and proxy.
///  - Inside: each verified pose, by exact intersection.
///  - Jams: the force is 0.1 N beyond that by all pairs of triangles within the hand's reach, and
///    the proxy moves less than a tenth of what the hand does; a verified pose that has not moved
///    by a margin though ten margins of the way to where it was led are free.
///  - Falls: there is no force, though by all pairs of triangles within the hand's reach there
///    would be more than 0.1 N, and the tool would be inside at one of eight places on the way to
///    0.1 N, or the way of a tick, before the hand.
///  - Cone: what of the force no sum of pushes of the contacts explains, of the force; contacts
///    that are being let out count.
///  - Steps: |ΔF| less what the hand's motion and the blending of contacts make of it,
///    k_T |Δhand| + dt/blend_time (F_out + F_in): F_out the largest of this tick and of the
///    blend_time before it, F_in what the contacts of the set would push the last proxy with, all
///    at once.
class RigidJudge {
 public:
  /// Views; the shapes must outlive it.
  RigidJudge(const MeshShape& object, const MeshShape& tool, const RigidJudgeOptions& options);

  /// `set` as the tick used it; null: none yet.
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
    Vec3 tool_point_T, normal_W, arm_W;  // the arm as it was then
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
  std::vector<double> fading_;  // forces [N] of the ticks that blending may still let out
  Found found_;
  std::array<std::vector<Push>, kSetsKept> pushes_;  // of the last sets
  bool has_set_ = false, has_frame_ = false;
  uint64_t last_seq_ = 0;
  Pose last_X_WG_;
  ServoFrame last_{};
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
