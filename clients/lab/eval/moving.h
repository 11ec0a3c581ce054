// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "clients/lab/eval/scenes/moving_scenes.h"
#include "clients/lockstep/lockstep.h"
#include "clients/report/report.h"

namespace haptic {

struct MovingEval {
  uint64_t scenes = 1000;
  uint64_t first_seed = 1;
  LockstepOptions lockstep;
};

/// Counts from one session among moving objects, found by closed forms and CGAL's exact predicates,
/// without any collision query of contact.
struct MovingFound {
  uint64_t scenes = 0, ticks = 0, felt = 0, not_finite = 0;
  uint64_t poses = 0, inside = 0;
  uint64_t sides_changed = 0;  // scenes with a verified pose on the wrong side of an object
  uint64_t across = 0;         // ticks with a force while the proxy is on the wrong side
  uint64_t placed_anew = 0;    // sets with kContactReseeded
  uint64_t closed = 0;         // ticks without a known pose, in which nothing is rendered
  uint64_t behind = 0;         // sets with an object away from its true position
  double most_behind = 0;      // largest such distance [m]
  double largest_force = 0;    // [N]

  void add(const MovingFound& other);
  bool has_missed() const;
};

/// Checks a session in every tick. A verified pose must be free of the objects where its set places
/// them, and on the side of each on which the free way runs. A force pulls across an object if the
/// servo's proxy is on another side than the free way: a hand that has gone through an object must
/// be pulled back to the side it came from.
class MovingJudge {
 public:
  /// The scene must outlive it.
  explicit MovingJudge(const MovingScene& scene) : scene_(scene) { found_.scenes = 1; }

  /// `set` as used by the tick, null before the first; `t`: time since the session began [s].
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

/// Runs a session of servo, contact and sim in lockstep.
MovingFound run_moving(const MovingScene& scene, Renderer renderer, const LockstepOptions& options);

/// `hapt eval moving`: both renderers whose tool never enters an object, in every scene.
void eval_moving(const MovingEval& eval, const Rows& all);

}  // namespace haptic
