// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval/rigid_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kFelt = 1e-6;      // [N]; weaker forces count as none
constexpr double kJamForce = 0.1;   // [N] beyond the exact force
constexpr double kJamShare = 0.1;   // of the hand's motion in a tick
constexpr double kJamMargins = 10;  // feasible motion of a jammed pose, in margins
constexpr double kBandMargins = 8;  // band of triangle pairs around a resting pose, in margins
constexpr double kAheadTicks = 2;   // ticks of hand motion for which contacts are known in advance
constexpr int kPlacesAsked = 8;     // tested along the path when the force is missing
constexpr double kAnyPush = std::numeric_limits<double>::infinity();  // no bound
constexpr double kCone = 1e-6;                                        // of the force
constexpr double kStepRounding = 1e-6;  // [N]; rounding allowed beyond the predicted step

}  // namespace

RigidJudge::RigidJudge(const MeshShape& object, const MeshShape& tool,
                       const RigidJudgeOptions& options)
    : options_(options),
      poses_(object, tool, options.springs),
      metric_(
          factor_metric(spring_matrix(options.springs.translational, options.springs.rotational))),
      fading_(static_cast<size_t>(std::ceil(options.blend_time / options.dt)) + 1) {}

double RigidJudge::size_of(const Wrench& F_W) const {
  return spring_force(F_W, options_.springs.translational, options_.springs.rotational);
}

void RigidJudge::judge_pose(const ContactSet& set) {
  constexpr uint32_t kAnew = kContactReseeded | kContactNoFreePose;
  ++found_.poses;
  found_.unsettled += (set.flags & kContactIterationLimit) != 0;
  found_.placed_anew += (set.flags & kAnew) != 0;
  if ((set.flags & kContactNoFreePose) != 0) return;
  found_.inside += poses_.is_entered(set.X_WG);
  const WayLeft left =
      poses_.way_left(set.X_WG, set.X_WT, options_.margin, kBandMargins * options_.margin);
  found_.unknown += !left.is_known;
  found_.held += left.rows > 0;
  const double gone = has_set_ ? poses_.length_of(way_between(last_X_WG_, set.X_WG)) : 0;
  const bool is_stuck = has_set_ && gone < options_.margin;
  found_.jammed_poses += left.is_known && is_stuck && left.length > kJamMargins * options_.margin;
}

void RigidJudge::judge_cone(const ServoFrame& frame, const ContactSet& set) {
  rows_.clear();
  for (const std::vector<Push>& kept : pushes_) {
    for (const Push& push : kept) {
      // a faded contact moves with the tool, a rate-limited one keeps its old arm
      rows_.push_back(contact_row(rotate(set.X_WG.q, push.tool_point_T), push.normal_W, 0, 0));
      rows_.push_back(contact_row(push.arm_W, push.normal_W, 0, 0));
    }
  }
  const Twist unexplained = response(metric_, frame.F_coupling_W);
  const Twist left = least_constraint(metric_, -1.0 * unexplained, rows_).a;
  const double share = poses_.length_of(left) / poses_.length_of(unexplained);
  found_.off_cone = std::max(found_.off_cone, share);
}

/// Distance that the last proxy would move if all contacts were enforced at once [m].
double RigidJudge::let_in(const ContactSet& set) {
  rows_.clear();
  for (uint32_t i = 0; i < set.n_contacts; ++i) {
    const Contact& c = set.contacts[i];
    const Vec3 r_W = rotate(set.X_WG.q, c.tool_point_T);
    const double gap = dot(c.normal_O, set.X_WG.p + r_W - c.object_point_O);
    rows_.push_back(contact_row(r_W, c.normal_O, gap, kAnyPush));
  }
  const Twist last = way_between(set.X_WG, last_.X_WP);
  return poses_.length_of(least_constraint(metric_, last, rows_).a - last);
}

void RigidJudge::judge_step(const ServoFrame& frame, const ContactSet& set) {
  const Wrench &now = frame.F_coupling_W, &before = last_.F_coupling_W;
  const double step = size_of({now.f - before.f, now.t - before.t});
  const double k_T = options_.springs.translational;
  const double hand = k_T * poses_.length_of(way_between(last_.X_WT, frame.X_WT));
  const double in = k_T * let_in(set);
  const double out = std::max(size_of(now), *std::max_element(fading_.begin(), fading_.end()));
  const double blend = options_.dt / options_.blend_time * (in + out);
  found_.largest_step = std::max(found_.largest_step, step);
  found_.beyond_step = std::max(found_.beyond_step, step - hand - blend);
}

/// Whether the tool would be inside somewhere on its way to the hand, except near its end, where
/// contact may lag behind. A point past a constraint plane but around a corner is free.
bool RigidJudge::is_passed(const Pose& X_WG, const Twist& way, const Twist& hand) const {
  const double late = kJamForce / options_.springs.translational;
  const double back = std::max(late, poses_.length_of(hand));
  const double end = 1 - back / poses_.length_of(way);
  for (int i = kPlacesAsked; i > 0 && end > 0; --i) {
    if (poses_.is_entered(moved(X_WG, i * end / kPlacesAsked * way))) return true;
  }
  return false;
}

void RigidJudge::judge_force(const ServoFrame& frame, const ContactSet& set) {
  const Twist hand = way_between(last_.X_WT, frame.X_WT), way = way_between(set.X_WG, frame.X_WT);
  const double force = size_of(frame.F_coupling_W);
  const double proxy = poses_.length_of(way_between(last_.X_WP, frame.X_WP));
  const bool is_felt = force > kFelt, is_slow = proxy < kJamShare * poses_.length_of(hand);
  const double apart = options_.springs.translational * poses_.length_of(way);
  if (is_felt ? !is_slow : apart <= kJamForce) return;
  const double band = kBandMargins * options_.margin + kAheadTicks * poses_.length_of(hand);
  const WayLeft left = poses_.way_left(set.X_WG, frame.X_WT, options_.margin, band);
  if (!left.is_known) return;
  const double exact = options_.springs.translational * poses_.length_of(way - left.motion);
  found_.jammed_ticks += is_felt && force - exact > kJamForce;
  found_.fallen += !is_felt && exact > kJamForce && is_passed(set.X_WG, way, hand);
}

void RigidJudge::add(const ServoFrame& frame, const ContactSet* set) {
  ++found_.ticks;
  const double force = size_of(frame.F_coupling_W);
  if (!std::isfinite(force) || !is_finite(frame.X_WP)) {
    ++found_.not_finite;
    return;
  }
  found_.largest_force = std::max(found_.largest_force, force);
  found_.felt += force > kFelt;
  if (set != nullptr && (!has_set_ || set->seq != last_seq_)) {
    judge_pose(*set);
    std::vector<Push>& kept = pushes_[set->seq % kSetsKept];
    kept.clear();
    for (uint32_t i = 0; i < set->n_contacts; ++i) {
      const Contact& c = set->contacts[i];
      kept.push_back({c.tool_point_T, c.normal_O, rotate(set->X_WG.q, c.tool_point_T)});
    }
    last_X_WG_ = set->X_WG;
    last_seq_ = set->seq;
    has_set_ = true;
  }
  if (set != nullptr && options_.is_massless && force > kFelt) judge_cone(frame, *set);
  if (has_frame_ && set != nullptr) judge_step(frame, *set);
  if (has_frame_ && set != nullptr && options_.is_massless) judge_force(frame, *set);
  fading_[found_.ticks % fading_.size()] = force;
  last_ = frame;
  has_frame_ = true;
}

std::vector<Row> RigidJudge::rows(const std::string& case_name) const {
  Rows rows(case_name);
  const bool is_massless = options_.is_massless;
  rows.add("ticks", found_.ticks);
  rows.add("ticks with a force", found_.felt);
  rows.none("ticks not finite", found_.not_finite);
  rows.add("verified poses", found_.poses);
  rows.none("of them inside or meeting", found_.inside);
  rows.none("placed anew, or nowhere", found_.placed_anew);
  rows.add("held back by something", found_.held);
  rows.add("unsettled", found_.unsettled);
  rows.add("too near to be judged", found_.unknown);
  rows.none("jammed though there is way left", found_.jammed_poses);
  rows.add("force, max", found_.largest_force, "N");
  if (is_massless) {
    rows.none("ticks jammed against all pairs", found_.jammed_ticks);
    rows.none("ticks fallen through", found_.fallen);
    rows.at_most("force outside the cone of the contacts, max", found_.off_cone, "of it", kCone);
  }
  rows.add("step of force in a tick, max", found_.largest_step, "N");
  rows.at_most("step beyond hand and blending, max", found_.beyond_step, "N",
               goal_if(is_massless, kStepRounding));
  return rows.rows();
}

}  // namespace haptic
