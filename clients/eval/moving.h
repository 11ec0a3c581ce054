// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "clients/eval/scenes/moving_scenes.h"
#include "clients/lab/lockstep.h"
#include "clients/report/report.h"

namespace haptic {

struct MovingEval {
  uint64_t scenes = 1000;
  uint64_t first_seed = 1;
  LockstepOptions lockstep;
};

/// Counts of one session among moving objects. Closed forms and CGAL's exact predicates find them,
/// no collision query of contact.
struct MovingFound {
  uint64_t scenes = 0, ticks = 0, felt = 0, not_finite = 0;
  uint64_t poses = 0, inside = 0;
  uint64_t sides_changed = 0;  // scenes in which a verified pose was not on the side of the way
  uint64_t across = 0;         // ticks with a force whose proxy was not there
  uint64_t placed_anew = 0;    // sets that say so
  uint64_t closed = 0;         // ticks in which no pose was known and nothing was rendered
  uint64_t behind = 0;         // sets of which an object is elsewhere than it was at their time
  double most_behind = 0;      // [m]
  double largest_force = 0;    // [N]

  void add(const MovingFound& other);
};

/// Watches a session tick by tick. A verified pose is free of the objects where its set has them,
/// and on their side of the way. A force pulls across an object where it is rendered while the
/// servo's proxy is on another side of it than the free way: a hand that has gone through an object
/// is pulled back through it, to the side it came from, and nowhere else.
class MovingJudge {
 public:
  /// Of a scene that must outlive it.
  explicit MovingJudge(const MovingScene& scene) : scene_(scene) { found_.scenes = 1; }

  /// `set` as the tick used it; null: none yet. `t`: of the tick, since the session began [s].
  void add(const ServoFrame& frame, const ContactSet* set, double t);

  const MovingFound& found() const { return found_; }

 private:
  void judge_pose(const ContactSet& set, double t);
  bool is_on_side(const Pose& X_WT, double t) const;

  const MovingScene& scene_;
  MovingFound found_;
  bool has_set_ = false;
  uint64_t last_seq_ = 0;
};

/// A whole session of servo, contact and sim.
MovingFound run_moving(const MovingScene& scene, Renderer renderer, const LockstepOptions& options);

/// The whole of `hapt eval --suite moving`: both renderers whose tool never enters an object, in
/// every scene.
std::vector<Row> eval_moving(const MovingEval& eval);

}  // namespace haptic
