// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clients/lab/eval/way_left.h"
#include "clients/report/report.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Parameters of the check.
struct RigidJudgeOptions {
  WayLeftJudge::Springs springs;  // of the coupling
  double margin = 0;              // distance the tool keeps from surfaces [m]
  double dt = 1e-3;               // [s]
  bool is_massless = true;        // nor damped: springs and contacts alone make the force
  bool has_friction = false;
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
///  - Cone: the part of the spring between hand and proxy that no non-negative combination of the
///    set's contacts explains, relative to it.
///  - Between: how far the force lies from the segment between the last force and this spring, by
///    which a rate limit may hold it back, relative to the longer of them.
///  - Steps: the largest |ΔF| in a tick, compared with that of the exact force, which the springs
///    make by all pairs of triangles near each verified pose; with friction, with that of the
///    spring. A step that the exact force does not have is
///    felt as one beyond the just noticeable difference, 7 % of the force (Pang, Tan & Durlach
///    1991).
///  - Spectrum: root mean square of the force above 100 Hz, compared with the exact force.
class RigidJudge {
 public:
  /// Keeps views of the shapes, which must outlive it.
  RigidJudge(const MeshShape& object, const MeshShape& tool, const RigidJudgeOptions& options);

  /// `set` as used by the tick, null before the first.
  void add(const ServoFrame& frame, const ContactSet* set);

  void add_rows(const std::string& case_name, const Rows& all) const;

  struct Found {
    uint64_t ticks = 0, felt = 0, not_finite = 0;
    uint64_t poses = 0, inside = 0, unsettled = 0, placed_anew = 0;
    uint64_t held = 0, jammed_poses = 0, jammed_ticks = 0, fallen = 0, unknown = 0;
    double largest_force = 0, off_cone = 0, beside = 0;  // [N], of the force
    double largest_step = 0, reference_step = 0;         // [N]
  };
  const Found& found() const { return found_; }

 private:
  double size_of(const Wrench& F_W) const;
  void judge_pose(const ContactSet& set);
  void judge_cone(const ContactSet& set, const Wrench& spring_W);
  void judge_limit(const ServoFrame& frame, const Wrench& spring_W);
  void note_force(const Wrench& felt_W, const Wrench& reference_W);
  bool is_passed(const Pose& X_WG, const Twist& way, const Twist& hand) const;
  void judge_force(const ServoFrame& frame, const ContactSet& set, const Wrench& spring_W);

  RigidJudgeOptions options_;
  WayLeftJudge poses_;
  MotionMetric metric_;
  Found found_;
  std::vector<Vec3> felt_W_, reference_W_;  // force of each tick
  Wrench last_reference_W_;
  bool has_set_ = false, has_frame_ = false;
  uint64_t last_seq_ = 0;
  Pose last_X_WG_;
  ServoFrame last_{};
  std::vector<MotionRow> rows_;
};

}  // namespace haptic
