// SPDX-License-Identifier: GPL-3.0-or-later
// How the god-object of six degrees of freedom follows objects that move.
#include <limits>

#include "contact/detect/body/god_object6.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

// an attempt costs two passes over the fronts, as a move does; a step takes about ten of these
constexpr int kMostTries = 16;  // to follow parts of the objects' motion, in one step
constexpr int kRounds = 3;      // per attempt; each adds what the one before met as a constraint
// pairs visited by the fronts after which no attempt begins: a few times the cost of a thread
constexpr size_t kMostWork = 20'000;

}  // namespace

/// The pose of the tool if this object carried it along.
Pose GodObject6::carried_by(size_t object) const {
  HAPTIC_ASSERT(object < obstacles_.size());
  const Obstacle& o = obstacles_[object];
  const Pose X_WT = o.X_WO * o.X_OG;
  return {X_WT.p, normalized(X_WT.q)};
}

/// Moves to this pose, while the objects move to where they now are, if that is free.
bool GodObject6::goes(const Pose& X_WT) {
  HAPTIC_ASSERT(is_placed_);
  const FreePart free = free_part(X_WT);
  // the next motion begins here, for the fronts as well
  if (free.time == 1) stand_at(X_WT);
  if (free.time < 1 || !free.are_fronts_there) look_around();
  return free.time == 1;
}

bool GodObject6::goes_rigidly() {
  if (!contacts_.empty() && goes(carried_by(contacts_[0].object))) return true;
  return goes(X_WG_);
}

bool GodObject6::goes_with_any() {
  for (size_t i = 0; i < obstacles_.size(); ++i) {
    if (goes(carried_by(i))) return true;
  }
  return false;
}

/// By the least motion that leaves all contacts their margin where the objects now are.
bool GodObject6::gives_way() {
  for (int round = 0; round < kRounds; ++round) {
    gather_rows(std::numeric_limits<double>::infinity());
    const ConstrainedMotion motion = least_constraint(metric_, {}, motion_rows_);
    if (!motion.converged || motion.contradictory) return false;
    if (goes(moved(X_WG_, motion.a))) return true;
  }
  return false;
}

/// In parts: half as long after a failure, twice as long after a success. False if a part remains:
/// the objects are then where the tool is free of them.
bool GodObject6::gives_way_in_parts(std::span<const Pose> X_WO) {
  for (size_t i = 0; i < obstacles_.size(); ++i) {
    Obstacle& o = obstacles_[i];
    o.way_WO = motion_between(o.stood_WO, X_WO[i], {});
    o.n_kept = 0;
  }
  double gone = 0, part = 1;
  work_ = 0;
  for (int tries = 0; tries < kMostTries && gone < 1 && work_ < kMostWork; ++tries) {
    const double to = std::min(gone + part, 1.0);
    for (size_t i = 0; i < obstacles_.size(); ++i) {
      obstacles_[i].X_WO = to < 1 ? obstacles_[i].way_WO.at(to) : X_WO[i];
    }
    if (gives_way()) {
      gone = to;
      part *= 2;
      for (Obstacle& o : obstacles_) o.n_kept = 0;
    } else {
      part /= 2;
    }
  }
  for (Obstacle& o : obstacles_) o.X_WO = o.stood_WO;
  return gone == 1;
}

/// False if the objects have moved on without the tool.
bool GodObject6::follow_objects(std::span<const Pose> X_WO) {
  const auto see_objects = [&] {
    bool any_moved = false;
    for (size_t i = 0; i < obstacles_.size(); ++i) {
      any_moved |= obstacles_[i].X_WO != X_WO[i];
      obstacles_[i].X_WO = X_WO[i];
    }
    return any_moved;
  };
  if (!see_objects() || goes_rigidly() || gives_way_in_parts(X_WO)) return true;
  see_objects();
  if (goes_with_any()) return true;
  for (Obstacle& o : obstacles_) o.X_WO = o.stood_WO;
  return false;
}

}  // namespace haptic
