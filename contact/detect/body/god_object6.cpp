// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/god_object6.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/query/point/closest_point.h"
#include "contact/query/proximity/near_pairs.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kArrived = 0.05;  // margins: a shorter rest of the way counts as arrived
// a shorter rest is rounding: of the way to the target, and [m]; a pose that follows contacts which
// it makes itself would chase its own rounding
constexpr double kExact = 1e-10, kRounding = 1e-12;
// what a step may leave to the next one: a share of a way that took much work, and margins
constexpr double kRestShare = 0.1, kRest = 5;
constexpr size_t kMuchWork = 2000;   // pairs visited by the fronts
constexpr double kApart = 0.5;       // margins: nearer counts as meeting
constexpr double kStop = 0.01;       // margins kept before a meeting
constexpr int kMostBand = 20;        // largest band: 2^20 margins
constexpr int kLevelsKept = 2;       // hysteresis: levels by which the band may be too wide
constexpr double kAlmost = 0.999;    // a limit less its rounding
constexpr double kBend = 0.4;        // bands: deviation from a straight line that fronts can follow
constexpr double kLongWay = 0.02;    // tool sizes: longest motion that fronts follow in one move
constexpr double kWorthwhile = 0.1;  // least actual/predicted decrease (trust-region ratio)
constexpr double kTrustHit = 2;      // after a hit: trust radius = 2 × free path
constexpr double kTrustFree = 4;     // after a free move: trust radius × 4
constexpr double kLeastTrust = 16;   // least trust radius, in margins
constexpr int kLeastBand = 2;  // smallest band, 2^2 margins: active contacts are at one margin
constexpr size_t kMostNearPairs = 800;  // near pairs; with more the band shrinks
constexpr size_t kFewPairs = 100;       // near pairs; with at most so many the band may grow
constexpr size_t kMostRows = 128;       // of each object, in one move
// merges over shorter distances than the default, since 64 contacts are for the whole tool
constexpr NearContactOptions kThinned{.place = 0.01};
constexpr int kMostStepsBehind = 20;  // 20 ms at 1 kHz, as long as a scene is extrapolated
constexpr int kDistancesTried = 10;   // in the search for a free pose, each twice the one before

/// About the origin of T: the motion must begin as the rows assume, which hold for that rotation.
RigidMotion way_of(const Pose& from, const Pose& to) {
  return motion_between(from, to, {});
}

}  // namespace

GodObject6::GodObject6(std::span<const MeshShape> objects, const MeshShape& tool,
                       const ToolBody& body, const GodObject6Options& options)
    : options_(options),
      tool_(tool),
      shell_points_T_(points_of_shells(tool.mesh)),
      reach_(norm(body.centre_T) + body.radius),
      metric_(factor_metric(
          spring_matrix(options.translational_stiffness, options.rotational_stiffness))) {
  HAPTIC_ASSERT(objects.size() <= kMaxObjects);
  HAPTIC_ASSERT(options.margin > 0 && options.k_s > 0);
  HAPTIC_ASSERT(metric_.valid && reach_ > 0);
  obstacles_.reserve(objects.size());
  for (const MeshShape& object : objects) obstacles_.emplace_back(object, tool);
  rows_.reserve(kMostRows * objects.size());
  motion_rows_.reserve(kMostRows * objects.size());
  order_.reserve(kMostRows * objects.size());
  contacts_.reserve(kMaxContacts);
}

void GodObject6::set_springs(double translational, double rotational) {
  HAPTIC_ASSERT(translational > 0 && rotational > 0);
  if (translational == options_.translational_stiffness &&
      rotational == options_.rotational_stiffness) {
    return;
  }
  const MotionMetric metric = factor_metric(spring_matrix(translational, rotational));
  if (!metric.valid) return;
  options_.translational_stiffness = translational;
  options_.rotational_stiffness = rotational;
  metric_ = metric;
}

double GodObject6::length_of(const Twist& motion) const {
  return norm(motion.v) + reach_ * norm(motion.w);
}

double GodObject6::length_of(const RigidMotion& motion) const {
  return norm(motion.way_O) + reach_ * motion.angle;
}

/// |motion|_M as a translation [m].
double GodObject6::distance_of(const Twist& motion) const {
  return spring_length(motion, options_.translational_stiffness, options_.rotational_stiffness);
}

bool GodObject6::is_free_of(const Obstacle& o, const Pose& X_OT) const {
  return !any_near_pair(o.shape, tool_, X_OT, kApart * options_.margin) &&
         !holds(o.shape, shell_points_T_, X_OT) && !holds(tool_, o.shell_points, inverse(X_OT));
}

bool GodObject6::is_free(std::span<const Pose> X_WO, const Pose& X_WT) const {
  HAPTIC_ASSERT(X_WO.size() == obstacles_.size());
  if (!is_finite(X_WT)) return false;
  for (size_t i = 0; i < obstacles_.size(); ++i) {
    if (!is_free_of(obstacles_[i], inverse(X_WO[i]) * X_WT)) return false;
  }
  return true;
}

/// Whether an object lies on the way between the poses although the tool is free of it at `from`.
bool GodObject6::is_across(std::span<const Pose> X_WO, const Pose& from_W, const Pose& to_W) {
  for (size_t i = 0; i < obstacles_.size(); ++i) {
    Obstacle& o = obstacles_[i];
    const Pose from_O = inverse(X_WO[i]) * from_W, to_O = inverse(X_WO[i]) * to_W;
    if (!is_free_of(o, from_O)) continue;
    if (o.sweep.time_of_impact(way_of(from_O, to_O), kApart * options_.margin).meets) return true;
  }
  return false;
}

bool GodObject6::place(std::span<const Pose> X_WO, const Pose& X_WT) {
  if (!is_free(X_WO, X_WT)) return false;
  for (size_t i = 0; i < obstacles_.size(); ++i) obstacles_[i].X_WO = X_WO[i];
  contacts_.clear();
  n_active_ = 0;
  trust_ = kFar;
  is_placed_ = was_placed_ = true;
  steps_behind_ = 0;
  stand_at(X_WT);
  look_around();
  return true;
}

bool GodObject6::place_near(std::span<const Pose> X_WO, const Pose& X_WT) {
  if (place(X_WO, X_WT)) return true;
  const Pose before = X_WG_;
  if (was_placed_ && !is_across(X_WO, X_WT, before) && place(X_WO, before)) return true;
  double way = reach_ / 32;
  for (int i = 0; i < kDistancesTried; ++i, way *= 2) {
    // the 26 neighbours in a cube
    for (int k = 0; k < 27; ++k) {
      const Vec3 to{k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0};
      const Pose beside{X_WT.p + way * normalized(to), X_WT.q};
      if (k == 13 || !is_free(X_WO, beside)) continue;
      if (!is_across(X_WO, X_WT, beside) && place(X_WO, beside)) return true;
    }
  }
  return false;
}

void GodObject6::stand_at(const Pose& X_WT) {
  X_WG_ = X_WT;
  for (Obstacle& o : obstacles_) {
    o.X_OG = inverse(o.X_WO) * X_WT;
    o.stood_WO = o.X_WO;
  }
}

/// Updates the pairs within the band; shrinks the band if there are too many.
void GodObject6::look_around() {
  HAPTIC_ASSERT(band_ >= 0 && band_ <= kMostBand);
  for (;; --band_) {
    for (Obstacle& o : obstacles_) o.near = o.front.update(o.X_OG, band());
    if (n_near() <= kMostNearPairs || band_ <= kLeastBand) return;
  }
}

size_t GodObject6::n_near() const {
  size_t n = 0;
  for (const Obstacle& o : obstacles_) n += o.near.size();
  return n;
}

/// The free share of the motion to this pose relative to each object, along the object's own
/// motion. Short and nearly straight motions are followed by the fronts, and only the pairs that
/// these cannot prove apart are tested; else all are.
GodObject6::FreePart GodObject6::free_part(const Pose& to_W) {
  const double tolerance = kApart * options_.margin;
  FreePart free;
  for (Obstacle& o : obstacles_) {
    const Pose X_OT = inverse(o.X_WO) * to_W;
    const RigidMotion way = way_of(o.X_OG, X_OT);
    const bool is_followed = !o.front.is_first() && length_of(way) <= kLongWay * reach_ &&
                             off_the_chord(way, reach_, 1) <= kBend * band();
    if (is_followed) {
      o.near = o.front.follow(way, X_OT, band());
      const NearFront::Work& work = o.front.work();
      work_ += work.visited + work.boxes + work.triangles;
    }
    free.are_fronts_there &= is_followed;
    const MeshMeeting meeting = is_followed
                                    ? o.sweep.time_of_impact(way, tolerance, o.front.suspects())
                                    : o.sweep.time_of_impact(way, tolerance);
    if (!meeting.meets) continue;
    o.keep(meeting.pair);
    free.time = std::min(free.time, meeting.time);
  }
  return free;
}

void GodObject6::add_row(const NearContact& contact, uint32_t object, bool is_kept) {
  if (rows_.size() == row_room_) return;
  HAPTIC_ASSERT(object < obstacles_.size() && rows_.size() < rows_.capacity());
  const Obstacle& o = obstacles_[object];
  const Vec3 point_W = o.stood_WO * contact.point_b, normal_W = rotate(o.X_WO.q, contact.normal_A);
  // the object may have moved on, the tool has not
  const double nearer = dot(normal_W, o.X_WO * contact.point_b - point_W);
  const double gap = contact.distance - options_.margin - nearer;
  rows_.push_back({contact, object, is_kept});
  motion_rows_.push_back(contact_row(point_W - X_WG_.p, normal_W, gap, most_push_));
}

void GodObject6::gather_rows(double most_push) {
  most_push_ = most_push;
  rows_.clear();
  motion_rows_.clear();
  for (uint32_t i = 0; i < obstacles_.size(); ++i) {
    Obstacle& o = obstacles_[i];
    // reserves room for the contacts of the whole tool
    row_room_ = rows_.size() + kMostRows - NearContacts::kRoom;
    add_kept(o, i);
    add_too_near(o, i);
    row_room_ += NearContacts::kRoom;
    const NearContactSet set = o.minima.reduce(o.near, o.X_OG, kThinned);
    for (const NearContact& contact : set.contacts) add_row(contact, i);
  }
}

void GodObject6::add_pair(const TrianglePair& triangles, const TriangleDistance& at,
                          uint32_t object, bool is_kept) {
  if (!(at.distance > 0)) return;
  add_row(contact_of(obstacles_[object].shape.mesh, tool_.mesh, triangles, at), object, is_kept);
}

/// Pairs nearer than half the margin are constraints even if they would be merged or are no local
/// minimum: around a corner that close the next surface is met at once.
void GodObject6::add_too_near(const Obstacle& o, uint32_t object) {
  for (const NearPair& pair : o.near) {
    if (pair.at.distance < kApart * options_.margin) {
      add_pair(pair.triangles, pair.at, object, false);
    }
  }
}

/// Pairs that were met or active in this step are retained, however far they are now: else the tool
/// chatters, and each move discards what the last one learned.
void GodObject6::add_kept(const Obstacle& o, uint32_t object) {
  for (const TrianglePair& kept : o.kept()) {
    const Corners a_O = corners_of(o.shape.mesh, kept.a);
    add_pair(kept, triangle_distance(a_O, corners_of(tool_.mesh, kept.b, o.X_OG)), object, true);
  }
}

ConstrainedMotion GodObject6::constrained_way(const Twist& way) {
  const ConstrainedMotion motion = least_constraint(metric_, way, motion_rows_, {});
  HAPTIC_ASSERT(motion.n_active >= 0 && static_cast<size_t>(motion.n_active) <= active_.size());
  active_ = motion.active;
  n_active_ = motion.n_active;
  for (int j = 0; j < n_active_; ++j) {
    const GodObjectContact& row = rows_[static_cast<size_t>(active_[static_cast<size_t>(j)])];
    obstacles_[row.object].keep(row.at.triangles);
  }
  return motion;
}

/// The share of a motion that is tried at once. Long motions are limited by the trust radius; the
/// rotation of short ones such that no point deviates from its chord by more than a share of the
/// band, r θ²/8, beyond which the fronts cannot follow.
double GodObject6::share_of(const Twist& motion) const {
  const double length = length_of(motion);
  const double share = std::min(trust_ / length, 1.0);
  if (share * length > kLongWay * reach_) return share;
  const double longest_turn = std::sqrt(8 * kAlmost * kBend * band() / reach_);
  return std::min(share, longest_turn / norm(motion.w));
}

/// The smallest level with a band of at least this length [m].
int GodObject6::level_of(double length) const {
  const double level = std::ceil(std::log2(std::max(length / options_.margin, 1.0)));
  return std::min(static_cast<int>(level), kMostBand);
}

/// Moves as far as is free. Returns the share of the motion done.
double GodObject6::advance(const Twist& motion) {
  const Pose to_W = moved(X_WG_, motion);
  const FreePart free = free_part(to_W);
  if (free.time == 1) {
    stand_at(to_W);
    if (!free.are_fronts_there || (n_near() > kMostNearPairs && band_ > kLeastBand)) look_around();
    return 1;
  }
  const double time = std::max(free.time - kStop * options_.margin / length_of(motion), 0.0);
  if (time > 0) stand_at(way_of(X_WG_, to_W).at(time));
  look_around();
  return time;
}

GodObjectMove GodObject6::move(std::span<const Pose> X_WO, const Pose& led_W, double reach) {
  HAPTIC_ASSERT(is_placed_);
  HAPTIC_ASSERT(X_WO.size() == obstacles_.size());
  HAPTIC_ASSERT(is_finite(led_W) && reach >= 0);
  GodObjectMove result;
  result.is_behind = !follow_objects(X_WO);
  steps_behind_ = result.is_behind ? steps_behind_ + 1 : 0;
  result.is_lost = steps_behind_ > kMostStepsBehind;
  for (Obstacle& o : obstacles_) o.n_kept = 0;
  result.is_settled = false;
  // each change costs a pass over the fronts; doubling the band may quadruple the pairs
  const int level = std::max(level_of(reach), kLeastBand);
  if (level < band_ - kLevelsKept) --band_;
  look_around();
  for (int wider = band_ + 1; wider <= level && n_near() <= kFewPairs; ++wider) {
    band_ = wider;
    look_around();
    if (band_ < wider) break;
  }
  double left = kFar, hoped = 0, gone_so_far = 0;
  work_ = 0;
  for (uint32_t i = 0; i <= options_.moves; ++i) {
    gather_rows(options_.margin);
    const Twist way = way_between(X_WG_, led_W);
    const Twist motion = constrained_way(0.5 * options_.k_s * way).a;
    const double length = length_of(motion), before = std::exchange(left, distance_of(way));
    // arrived; or so near that the decrease or the work is no longer worth it
    const bool is_near = distance_of(motion) <= kRest * options_.margin;
    const bool is_vain = before < kFar && before - left < kWorthwhile * hoped;
    const bool is_small = work_ > kMuchWork && length <= kRestShare * gone_so_far;
    const bool is_there = length <= kArrived * options_.margin;
    result.is_settled = is_there || (is_near && (is_vain || is_small));
    // at rest one short move in each step makes the pose exact
    const bool is_inexact =
        i == 0 && is_there && length > std::max(kExact * length_of(way), kRounding);
    if ((result.is_settled && !is_inexact) || i == options_.moves) break;
    const double share = share_of(motion);
    const double gone = advance(share * motion);
    gone_so_far += gone * share * length;
    trust_ = gone < 1 ? std::max(kTrustHit * gone * share * length, kLeastTrust * options_.margin)
                      : kTrustFree * trust_;
    // predicted from the done share s alone: |x + s a|² ≤ |x|² − s |a|²
    const double step = distance_of(motion);
    hoped = left > 0 ? gone * share * step * step / (2 * left) : 0;
    if (i == 0) result.free_fraction = gone;
  }
  result.n_active = static_cast<uint32_t>(n_active_);
  return result;
}

std::span<const GodObjectContact> GodObject6::contacts(const Pose& answered_W) {
  HAPTIC_ASSERT(is_placed_);
  HAPTIC_ASSERT(rows_.size() == motion_rows_.size() && rows_.size() <= order_.capacity());
  const Twist way = way_between(X_WG_, answered_W);
  order_.clear();
  for (size_t k = 0; k < rows_.size(); ++k) {
    const auto active_end = active_.begin() + n_active_;
    const bool is_active =
        std::find(active_.begin(), active_end, static_cast<int>(k)) != active_end;
    if (rows_[k].is_kept && !is_active) continue;
    // slack of the constraint: violated ones come before distant ones
    const double slack = dot(motion_rows_[k].J, way) - motion_rows_[k].b;
    const double rank = is_active ? -kFar : slack < 0 ? slack : rows_[k].at.distance;
    order_.push_back({rank, k});
  }
  std::sort(order_.begin(), order_.end());
  contacts_.clear();
  for (const auto& [rank, k] : order_) {
    const bool is_known =
        std::any_of(contacts_.begin(), contacts_.end(), [&](const GodObjectContact& c) {
          return c.object == rows_[k].object && c.at.feature == rows_[k].at.feature;
        });
    if (is_known) continue;
    if (contacts_.size() == kMaxContacts) break;
    contacts_.push_back(rows_[k]);
  }
  return contacts_;
}

}  // namespace haptic
