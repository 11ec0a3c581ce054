// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/rigid_judge.h"

#include <algorithm>
#include <cmath>

#include "clients/lab/support/spectrum.h"
#include "proto/wire/guide.h"

namespace haptic {
namespace {

constexpr double kFeltForce = 1e-6;    // [N]; weaker forces count as none
constexpr double kBodyJamForce = 0.1;  // [N] beyond the exact force
constexpr double kBodyJamShare = 0.1;  // of the hand's motion in a tick
constexpr double kJamMargins = 10;     // feasible motion of a jammed pose, in margins
constexpr double kBandMargins = 8;     // band of triangle pairs around a resting pose, in margins
constexpr double kAheadTicks = 2;  // ticks of hand motion for which contacts are known in advance
constexpr int kPlacesAsked = 8;    // tested along the path when the force is missing
constexpr double kCone = 1e-6;     // of the force
constexpr double kNoticed = 0.07;  // of the force: just noticeable (Pang, Tan & Durlach 1991)
constexpr double kRough = 100;     // above it a force is felt as roughness [Hz]
constexpr double kRougher = 1.1;   // than the exact force, at most

/// Wrench of the coupling's springs for a motion from the hand to the proxy, at the tool's origin.
Wrench spring_of(const WayLeftJudge::Springs& springs, const Twist& motion) {
  return {springs.translational * motion.v, springs.rotational * motion.w};
}

}  // namespace

RigidJudge::RigidJudge(const MeshShape& object, const MeshShape& tool,
                       const RigidJudgeOptions& options)
    : options_(options),
      poses_(object, tool, options.springs),
      metric_(
          factor_metric(spring_matrix(options.springs.translational, options.springs.rotational))) {
}

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

void RigidJudge::judge_cone(const ContactSet& set, const Wrench& spring_W) {
  rows_.clear();
  const auto arm_of = [&](const auto& row) { return rotate(set.X_WG.q, row.tool_point_T); };
  for (const Contact& c : set.contacts) rows_.push_back(contact_row(arm_of(c), c.normal_O, 0, 0));
  // what is grasped is held both ways
  for (const GuideRow& guide : set.guides) {
    rows_.push_back(contact_row(arm_of(guide), guide.normal_O, 0, 0));
    rows_.push_back(contact_row(arm_of(guide), -guide.normal_O, 0, 0));
  }
  const Twist unexplained = response(metric_, spring_W);
  const Twist left = least_constraint(metric_, -1.0 * unexplained, rows_).a;
  const double share = poses_.length_of(left) / poses_.length_of(unexplained);
  found_.off_cone = std::max(found_.off_cone, share);
}

void RigidJudge::judge_limit(const ServoFrame& frame, const Wrench& spring_W) {
  const Twist last = response(metric_, last_.F_coupling_W);
  const Twist now = response(metric_, frame.F_coupling_W);
  const Twist whole = response(metric_, spring_W) - last;
  const double length = poses_.length_of(whole);
  const double share = length > 0 ? std::min(poses_.length_of(now - last) / length, 1.0) : 0;
  const double longest = std::max(size_of(spring_W), size_of(last_.F_coupling_W));
  if (!(longest > kFeltForce)) return;
  const double k_T = options_.springs.translational;
  const double beside = k_T * poses_.length_of(now - last - share * whole);
  found_.beside = std::max(found_.beside, beside / longest);
}

void RigidJudge::note_force(const Wrench& felt_W, const Wrench& reference_W) {
  if (!felt_W_.empty()) {
    found_.reference_step =
        std::max(found_.reference_step, size_of(reference_W + -last_reference_W_));
  }
  last_reference_W_ = reference_W;
  felt_W_.push_back(felt_W.f);
  reference_W_.push_back(reference_W.f);
}

/// True if the tool would be inside somewhere on its way to the hand, except near its end, where
/// contact may lag behind. A point past a constraint plane but around a corner is free.
bool RigidJudge::is_passed(const Pose& X_WG, const Twist& way, const Twist& hand) const {
  const double late = kBodyJamForce / options_.springs.translational;
  const double back = std::max(late, poses_.length_of(hand));
  const double end = 1 - back / poses_.length_of(way);
  for (int i = kPlacesAsked; i > 0 && end > 0; --i) {
    if (poses_.is_entered(moved(X_WG, i * end / kPlacesAsked * way))) return true;
  }
  return false;
}

void RigidJudge::judge_force(const ServoFrame& frame, const ContactSet& set,
                             const Wrench& spring_W) {
  const Twist hand = way_between(last_.X_WT, frame.X_WT), way = way_between(set.X_WG, frame.X_WT);
  const double band = kBandMargins * options_.margin + kAheadTicks * poses_.length_of(hand);
  const WayLeft left = poses_.way_left(set.X_WG, frame.X_WT, options_.margin, band);
  note_force(frame.F_coupling_W,
             left.is_known ? spring_of(options_.springs, left.motion - way) : spring_W);
  const double force = size_of(spring_W);
  const double proxy = poses_.length_of(way_between(last_.X_WP, frame.X_WP));
  const bool is_felt = force > kFeltForce, is_slow = proxy < kBodyJamShare * poses_.length_of(hand);
  const double apart = options_.springs.translational * poses_.length_of(way);
  if (!left.is_known || (is_felt ? !is_slow : apart <= kBodyJamForce)) return;
  const double exact = options_.springs.translational * poses_.length_of(way - left.motion);
  found_.jammed_ticks += is_felt && force - exact > kBodyJamForce;
  found_.fallen += !is_felt && exact > kBodyJamForce && is_passed(set.X_WG, way, hand);
}

void RigidJudge::add(const ServoFrame& frame, const ContactSet* set) {
  ++found_.ticks;
  const double force = size_of(frame.F_coupling_W);
  if (!std::isfinite(force) || !is_finite(frame.X_WP)) {
    ++found_.not_finite;
    return;
  }
  found_.largest_force = std::max(found_.largest_force, force);
  found_.felt += force > kFeltForce;
  if (set != nullptr && (!has_set_ || set->seq != last_seq_)) {
    judge_pose(*set);
    last_X_WG_ = set->X_WG;
    last_seq_ = set->seq;
    has_set_ = true;
  }
  if (has_frame_) {
    const Wrench step_W = frame.F_coupling_W + -last_.F_coupling_W;
    found_.largest_step = std::max(found_.largest_step, size_of(step_W));
  }
  if (set != nullptr && options_.is_massless) {
    // motions from the verified pose, as their rotation vectors do not add up
    const Wrench spring_W = spring_of(
        options_.springs, way_between(set->X_WG, frame.X_WP) - way_between(set->X_WG, frame.X_WT));
    if (has_frame_) judge_limit(frame, spring_W);
    if (!options_.has_friction) {
      if (size_of(spring_W) > kFeltForce) judge_cone(*set, spring_W);
      if (has_frame_) judge_force(frame, *set, spring_W);
    } else {
      note_force(frame.F_coupling_W, spring_W);
    }
  }
  last_ = frame;
  has_frame_ = true;
}

void RigidJudge::add_rows(const std::string& case_name, const Rows& all) const {
  Rows rows = all.of(case_name);
  rows.add({{"ticks", found_.ticks},
            {"ticks with a force", found_.felt},
            {"ticks not finite", found_.not_finite, "", kMustBeZero},
            {"verified poses", found_.poses},
            {"of them inside or meeting", found_.inside, "", kMustBeZero},
            {"placed anew, or nowhere", found_.placed_anew, "", kMustBeZero},
            {"held back by something", found_.held},
            {"unsettled", found_.unsettled},
            {"too near to be judged", found_.unknown},
            {"jammed though there is way left", found_.jammed_poses, "", kMustBeZero},
            {"force, max", found_.largest_force, "N"}});
  if (options_.is_massless && !options_.has_friction) {
    rows.add({{"ticks jammed against all pairs", found_.jammed_ticks, "", kMustBeZero},
              {"ticks fallen through", found_.fallen, "", kMustBeZero},
              {"spring outside the cone of the contacts, max", found_.off_cone, "of it",
               at_most(kCone)}});
  }
  if (!options_.is_massless) {
    rows.add("step of force in a tick, max", found_.largest_step, "N");
    return;
  }
  rows.add(
      {{"force not between the last and the spring's, max", found_.beside, "of it", at_most(kCone)},
       {"step of the exact force in a tick, max", found_.reference_step, "N"},
       {"step of force in a tick, max", found_.largest_step, "N",
        at_most(std::max(found_.reference_step, kNoticed * found_.largest_force))}});
  const double exact = rms_above(reference_W_, 1 / options_.dt, kRough);
  rows.add({{"exact force above 100 Hz, root mean square", exact, "N"},
            {"force above 100 Hz, root mean square", rms_above(felt_W_, 1 / options_.dt, kRough),
             "N", at_most(kRougher * exact)}});
}

}  // namespace haptic
