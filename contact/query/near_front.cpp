// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/near_front.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace haptic {
namespace {

constexpr int kPartDepth = 5;          // of B's tree: 63 parts at most
constexpr double kBucketsOfBand = 16;  // buckets as wide as the band
constexpr double kLeastBucket = 1e-5;  // of the size of B
constexpr double kLeastWidth = 1e-9;   // of a bucket [m]
constexpr double kRaise = 0.5;         // of the slack that a parent must keep
constexpr double kLeave = 4;          // bands that triangles are apart before boxes are asked again
constexpr size_t kBoxesAsked = 3000;  // for any near pair, before the front is
constexpr double kMostTravel = 1e3;   // beyond it the roundings of sums count [m]
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// axes of boxes in floats, and roundings of the way itself
constexpr double kAxes = 1e-5, kRounding = 1e-14;
constexpr float kUlp = 1.2e-7F;
constexpr float kWayStep = 1 / 32767.F;
// of a gap along a direction in steps: of itself, and of the half diagonals of both boxes
constexpr float kWayError = 1e-4F;
constexpr double kWayRounding = 2e-4;

std::vector<Corners> corners_in_order(const MeshShape& shape) {
  std::vector<Corners> corners;
  corners.reserve(shape.tree.order.size());
  for (const uint32_t t : shape.tree.order) corners.push_back(corners_of(shape.mesh, t));
  return corners;
}

std::array<float, 3> to_floats(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
float length1(const std::array<float, 3>& v) {
  return std::fabs(v[0]) + std::fabs(v[1]) + std::fabs(v[2]);
}

float least_of(Lanes v) {
  v = v < __builtin_shufflevector(v, v, 2, 3, 0, 1) ? v : __builtin_shufflevector(v, v, 2, 3, 0, 1);
  return std::min(v[0], v[1]);
}
float least_of(const std::array<float, 16>& values) {
  Lanes least = load_lanes<Lanes>(&values[0]);
  for (size_t k = 4; k < values.size(); k += 4) {
    const Lanes v = load_lanes<Lanes>(&values[k]);
    least = v < least ? v : least;
  }
  return least_of(least);
}

/// Takes the gaps along where b has gone; returns the least.
template <class LeafBounds>
float move_bounds(LeafBounds& bounds, const std::array<float, 3>& way, float lost) {
  using Shorts [[gnu::vector_size(8)]] = int16_t;
  Lanes least = Lanes{} + kInfinity;
  for (size_t k = 0; k < bounds.at_least.size(); k += 4) {
    Lanes bound = (1 - 4 * kUlp) * load_lanes<Lanes>(&bounds.at_least[k]) - lost;
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto steps = load_lanes<Shorts>(&bounds.way[axis][k]);
      bound += kWayStep * way[axis] * __builtin_convertvector(steps, Lanes);
    }
    std::memcpy(&bounds.at_least[k], &bound, sizeof bound);
    least = bound < least ? bound : least;
  }
  return least_of(least);
}

/// At least how far it moves any unit vector.
double norm_of(const Mat3& m) {
  return std::sqrt(norm_squared(m.row[0]) + norm_squared(m.row[1]) + norm_squared(m.row[2]));
}

}  // namespace

NearFront::NearFront(const MeshShape& shape_A, const MeshShape& shape_B)
    : shape_A_(shape_A),
      shape_B_(shape_B),
      corners_A_(corners_in_order(shape_A)),
      corners_B_(corners_in_order(shape_B)),
      part_of_(shape_B.tree.nodes.size()) {
  if (!part_of_.empty()) make_parts(0, 0);
}

/// A part for each node of the upper levels; what is below them shares the last one made.
void NearFront::make_parts(uint32_t node, int depth) {
  const ObbNode& n = shape_B_.tree.nodes[node];
  if (depth <= kPartDepth) {
    const Obb box = n.box.unpacked();
    Part part;
    part.centre_B = box.centre_O;
    for (int i = 0; i < 3; ++i) part.spokes_B[i] = (1 + kAxes) * box.half[i] * box.R_BO.row[i];
    parts_.push_back(part);
  }
  part_of_[node] = static_cast<uint8_t>(parts_.size() - 1);
  if (n.count > 0) return;
  make_parts(n.first, depth + 1);
  make_parts(n.first + 1, depth + 1);
}

std::span<const NearPair> NearFront::update(const Pose& X_AB, double band) {
  near_.clear();
  suspects_.clear();
  work_ = {};
  const bool is_band = std::isfinite(band) && band >= 0;
  if (part_of_.empty() || corners_A_.empty() || !is_finite(X_AB) || !is_band) return {};
  note_travel(X_AB);
  boxes_ = BoxDistance(X_AB);
  if (band != band_ || is_fresh_) change_band(band);
  if (is_fresh_) {
    begin();
  } else {
    for (Part& part : parts_) {
      const auto bucket = static_cast<int64_t>(part.travel / bucket_width_);
      take_expired(part, std::exchange(part.bucket, bucket));
    }
    visit_expired();
  }
  measure_waiting();
  return near_;
}

std::span<const NearPair> NearFront::follow(const RigidMotion& motion, double band) {
  // bounds that were kept for a narrower band say too little of the way
  if (!is_fresh_ && band > band_) update(X_AB_, band);
  const ObbSweep sweep = sweep_between(motion, 0, 1);
  sweep_ = &sweep;
  const std::span<const NearPair> near = update(motion.at(1), band);
  sweep_ = nullptr;
  return near;
}

/// An empty front: the roots, in no bucket.
void NearFront::begin() {
  pairs_.assign(2, {});
  next_.assign(2, kNone);
  bounds_.clear();
  unused_bounds_.clear();
  unused_halves_ = kNone;
  for (Part& part : parts_) {
    part.first.fill(kNone);
    part.travel = 0;
    part.bucket = 0;
  }
  turned_ = 0;
  is_fresh_ = false;
  open(0);
}

/// Adds the way of each part since the last pose.
void NearFront::note_travel(const Pose& X_AB) {
  const Mat3 R = to_matrix(X_AB.q), before = to_matrix(X_AB_.q);
  const Vec3 p = X_AB.p - X_AB_.p;
  const Mat3 turn{{R.row[0] - before.row[0], R.row[1] - before.row[1], R.row[2] - before.row[2]}};
  const double rounding = kRounding * (norm(X_AB.p) + norm(X_AB_.p));
  turned_ += norm_of(turn) + kRounding;
  for (Part& part : parts_) {
    const Vec3 centre = p + turn * part.centre_B;
    const Vec3 x = turn * part.spokes_B[0], y = turn * part.spokes_B[1],
               z = turn * part.spokes_B[2];
    double most = 0;
    for (const Vec3& corner :
         {centre + x + y + z, centre + x + y - z, centre + x - y + z, centre + x - y - z,
          centre - x + y + z, centre - x + y - z, centre - x - y + z, centre - x - y - z}) {
      most = std::max(most, norm_squared(corner));
    }
    const double size = norm(part.centre_B) + norm(part.spokes_B[0]) + norm(part.spokes_B[1]) +
                        norm(part.spokes_B[2]);
    const double way = std::sqrt(most) + rounding + kRounding * size;
    part.travel += way;
    part.way = sweep_ != nullptr ? way : 0;
    // a box without bounds, or too long a way for sums
    is_fresh_ = is_fresh_ || !(part.travel < kMostTravel);
  }
  X_AB_before_ = std::exchange(X_AB_, X_AB);
}

/// Puts everything that waits in buckets for the new band.
void NearFront::change_band(double band) {
  band_ = band;
  const Vec3 size = shape_B_.mesh.upper - shape_B_.mesh.lower;
  bucket_width_ = std::max(band / kBucketsOfBand, kLeastBucket * norm(size)) + kLeastWidth;
  if (is_fresh_) return;
  for (Part& part : parts_) {
    part.first.fill(kNone);
    part.bucket = static_cast<int64_t>(part.travel / bucket_width_);
  }
  for (uint32_t i = 0; i < pairs_.size(); ++i) {
    const Pair& pair = pairs_[i];
    // bounds of triangles are looked at to find when they expire: at once
    if (pair.state == State::kLeaves) put_in_bucket(i, part_of(pair).travel);
    if (pair.state == State::kFar) put_in_bucket(i, pair.until - band_);
    if (pair.state == State::kReplaced) put_in_bucket(i, part_of(pair).travel);
  }
}

/// Takes everything out of the buckets that the part has come through.
void NearFront::take_expired(Part& part, int64_t last_bucket) {
  const int64_t n = std::min<int64_t>(part.bucket - last_bucket + 1, kBuckets);
  for (int64_t k = 0; k < n; ++k) {
    uint32_t& first = part.first[static_cast<size_t>(part.bucket - k) % kBuckets];
    for (uint32_t i = std::exchange(first, kNone); i != kNone; i = next_[i]) expired_.push_back(i);
  }
}

/// The front is larger than caches: what comes soon is fetched ahead.
void NearFront::visit_expired() {
  constexpr size_t kPairsAhead = 24, kBoundsAhead = 12;
  const size_t n = expired_.size();
  for (size_t i = 0; i < n; ++i) {
    __builtin_prefetch(&pairs_[expired_[std::min(i + kPairsAhead, n - 1)]]);
    const Pair& soon = pairs_[expired_[std::min(i + kBoundsAhead, n - 1)]];
    __builtin_prefetch(&shape_A_.tree.nodes[soon.nodes.a]);
    __builtin_prefetch(&shape_B_.tree.nodes[soon.nodes.b]);
    if (soon.state == State::kLeaves) {
      const auto* lines = reinterpret_cast<const char*>(&bounds_[soon.below]);
      for (size_t line = 0; line < sizeof(LeafBounds); line += 64) __builtin_prefetch(lines + line);
    }
    visit(expired_[i]);
  }
  expired_.clear();
}

void NearFront::visit(uint32_t index) {
  ++work_.visited;
  Pair& pair = pairs_[index];
  if (pair.state == State::kReplaced) {
    // its other half has waited for this
    const uint32_t first = index & ~1u;
    pairs_[first].state = pairs_[first + 1].state = State::kUnused;
    next_[first] = std::exchange(unused_halves_, first);
  } else if (pair.state == State::kLeaves) {
    look_at_leaves(index);
  } else if (pair.until - band_ > part_of(pair).travel) {
    put_in_bucket(index, pair.until - band_);
  } else {
    const double apart = at_least(pair.nodes);
    is_far(pair, apart) ? raise(index, apart) : open(index);
  }
}

void NearFront::open(uint32_t index) {
  const NodePair nodes = pairs_[index].nodes;
  const ObbTree &tree_A = shape_A_.tree, &tree_B = shape_B_.tree;
  const uint32_t n_a = tree_A.nodes[nodes.a].count, n_b = tree_B.nodes[nodes.b].count;
  if (n_a > 0 && n_b > 0) {
    pairs_[index].state = State::kLeaves;
    pairs_[index].below = new_bounds();
    begin_leaves(index);
    look_at_leaves(index);
    return;
  }
  const uint32_t first = new_halves();
  pairs_[index].state = State::kOpen;
  pairs_[index].below = first;
  const std::array<NodePair, 2> halves = opened(nodes, tree_A, tree_B);
  for (uint32_t k = 0; k < 2; ++k) {
    Pair& half = pairs_[first + k];
    half = {};
    half.nodes = halves[k];
    half.parent = index;
    half.part = part_of_[halves[k].b];
    half.state = State::kOpen;
  }
  for (uint32_t k = 0; k < 2; ++k) {
    const double apart = at_least(halves[k]);
    is_far(pairs_[first + k], apart) ? wait_far(first + k, apart) : open(first + k);
  }
}

/// Nothing is known but how many there are.
void NearFront::begin_leaves(uint32_t index) {
  const Pair& pair = pairs_[index];
  const ObbNode &a = shape_A_.tree.nodes[pair.nodes.a], &b = shape_B_.tree.nodes[pair.nodes.b];
  const Obb box_a = a.box.unpacked(), box_b = b.box.unpacked();
  LeafBounds& bounds = bounds_[pair.below];
  bounds.at_least.fill(kInfinity);
  for (uint32_t j = 0; j < b.count; ++j) {
    for (uint32_t i = 0; i < a.count; ++i) bounds.at_least[kLeafTriangles * j + i] = 0;
  }
  bounds.way = {};
  bounds.centre_A = to_floats(X_AB_ * box_b.centre_O);
  bounds.turned = static_cast<float>(turned_);
  bounds.radius = static_cast<float>((1 + kAxes) * norm(box_b.half));
  bounds.rounding = static_cast<float>(kWayRounding * (norm(box_a.half) + norm(box_b.half)));
}

/// Moves the bounds to this pose; triangles that may be near now wait to be measured.
void NearFront::look_at_leaves(uint32_t index) {
  const Pair& pair = pairs_[index];
  const ObbNode &a = shape_A_.tree.nodes[pair.nodes.a], &b = shape_B_.tree.nodes[pair.nodes.b];
  LeafBounds& bounds = bounds_[pair.below];
  const auto& c = b.box.centre_O;
  const std::array<float, 3> centre = to_floats(X_AB_ * Vec3{c[0], c[1], c[2]});
  const float x = centre[0] - bounds.centre_A[0], y = centre[1] - bounds.centre_A[1],
              z = centre[2] - bounds.centre_A[2];
  const auto turned = static_cast<float>(turned_);
  const float turn = turned - bounds.turned + 2 * kUlp * turned;
  const float lost = (1 + 4 * kUlp) * turn * bounds.radius +
                     4 * kUlp * (length1(centre) + length1(bounds.centre_A));
  bounds.centre_A = centre;
  bounds.turned = turned;
  const auto before = bounds.at_least;
  const float least = move_bounds(bounds, {x, y, z}, lost);
  const float band = static_cast<float>(band_) * (1 + kUlp);
  // what was near at the pose before may have met since, where the way is not quite straight
  const float left = sweep_ != nullptr ? band : -kInfinity;
  if (least > band && least_of(before) > left) {
    leave_leaves(index, static_cast<double>(least));
    return;
  }
  if (batch_.n + kLeafPairs > DistanceBatch::kRoom) measure_waiting();
  leaves_[n_leaves_++] = index;
  for (uint32_t k = 0; k < kLeafPairs; ++k) {
    if (bounds.at_least[k] > band && before[k] > left) continue;
    waiting_[batch_.n] = {index, k};
    batch_.add(corners_A_[a.first + k % kLeafTriangles], corners_B_[b.first + k / kLeafTriangles]);
  }
}

void NearFront::measure_waiting() {
  measure(X_AB_, batch_);
  work_.triangles += batch_.n;
  for (size_t i = 0; i < batch_.n; ++i) {
    const auto [index, k] = waiting_[i];
    const Pair& pair = pairs_[index];
    const double distance2 = batch_.distance_squared[i];
    LeafBounds& bounds = bounds_[pair.below];
    const double per_length = distance2 > 0 ? 1 / std::sqrt(distance2) : 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto steps = static_cast<float>(per_length * batch_.way[axis][i]) / kWayStep;
      bounds.way[axis][k] = static_cast<int16_t>(steps);
    }
    const auto gap = static_cast<float>(per_length * batch_.gap[i]);
    bounds.at_least[k] = (1 - kWayError) * std::max(gap, 0.F) - bounds.rounding;
    const double suspect = band_ + part_of(pair).way;
    if (distance2 > suspect * suspect) continue;
    const size_t a = shape_A_.tree.nodes[pair.nodes.a].first + k % kLeafTriangles;
    const size_t b = shape_B_.tree.nodes[pair.nodes.b].first + k / kLeafTriangles;
    const TrianglePair triangles{shape_A_.tree.order[a], shape_B_.tree.order[b]};
    if (sweep_ != nullptr && !was_apart(i, a, b)) suspects_.push_back(triangles);
    if (distance2 <= band_ * band_) near_.push_back({triangles, measured(batch_, i)});
  }
  batch_.n = 0;
  // all that were looked at since the last time are measured now
  for (size_t i = 0; i < n_leaves_; ++i) {
    const auto& bounds = bounds_[pairs_[leaves_[i]].below].at_least;
    leave_leaves(leaves_[i], static_cast<double>(least_of(bounds)));
  }
  n_leaves_ = 0;
}

/// Triangles wait until the slack of the nearest is used up. Where all are far they do so as boxes,
/// if these tell nearly as much.
void NearFront::leave_leaves(uint32_t index, double least) {
  const Pair& pair = pairs_[index];
  if (least > kLeave * band_) {
    const double apart = at_least(pair.nodes);
    if (apart - band_ > kRaise * (least - band_)) {
      unused_bounds_.push_back(pair.below);
      raise(index, apart);
      return;
    }
  }
  put_in_bucket(index, part_of(pair).travel + least - band_);
}

/// Lets the parent wait for both halves where it is far enough too, and its parent for it.
void NearFront::raise(uint32_t index, double apart) {
  while (index != 0 && pairs_[index ^ 1].state == State::kFar) {
    const uint32_t parent = pairs_[index].parent;
    const double of_parent = at_least(pairs_[parent].nodes);
    // the other half may not have been looked at since the pose before
    const double least = std::max(kRaise * (apart - band_), part_of(pairs_[parent]).way);
    if (of_parent - band_ <= least) break;
    // the other half is in a bucket: both are free when that comes
    pairs_[index].state = State::kUnused;
    pairs_[index ^ 1].state = State::kReplaced;
    index = parent;
    apart = of_parent;
  }
  wait_far(index, apart);
}

void NearFront::wait_far(uint32_t index, double apart) {
  Pair& pair = pairs_[index];
  pair.state = State::kFar;
  pair.until = part_of(pair).travel + apart;
  put_in_bucket(index, pair.until - band_);
}

/// Into the bucket in which this travel falls. What is beyond the last one is spread over the
/// later half of them, so that it does not come back all at once.
void NearFront::put_in_bucket(uint32_t index, double travel) {
  Part& part = part_of(pairs_[index]);
  const double ahead = travel / bucket_width_ - static_cast<double>(part.bucket);
  uint32_t steps = kBuckets / 2 + index * 2654435761u % (kBuckets / 2);
  if (ahead < kBuckets) steps = static_cast<uint32_t>(std::max(ahead, 0.0));
  uint32_t& first = part.first[static_cast<size_t>(part.bucket + steps) % kBuckets];
  next_[index] = std::exchange(first, index);
}

uint32_t NearFront::new_halves() {
  if (unused_halves_ != kNone) {
    return std::exchange(unused_halves_, next_[unused_halves_]);
  }
  pairs_.resize(pairs_.size() + 2);
  next_.resize(pairs_.size());
  return static_cast<uint32_t>(pairs_.size() - 2);
}

uint32_t NearFront::new_bounds() {
  if (unused_bounds_.empty()) {
    bounds_.emplace_back();
    return static_cast<uint32_t>(bounds_.size() - 1);
  }
  const uint32_t bounds = unused_bounds_.back();
  unused_bounds_.pop_back();
  return bounds;
}

double NearFront::at_least(const NodePair& nodes) {
  ++work_.boxes;
  return boxes_.at_least(shape_A_.tree.nodes[nodes.a].box, shape_B_.tree.nodes[nodes.b].box);
}

/// Whether boxes that are so far apart now were so on the way here too.
bool NearFront::is_far(const Pair& pair, double apart) const {
  if (!(apart > band_)) return false;
  const Part& part = parts_[pair.part];
  return apart > band_ + part.way ||
         !boxes_may_meet(shape_A_.tree.nodes[pair.nodes.a].box,
                         shape_B_.tree.nodes[pair.nodes.b].box, *sweep_);
}

/// Whether two measured triangles were apart at the pose before too, across the same way: then so
/// they were between. What that leaves open is no proof that they met.
bool NearFront::was_apart(size_t i, size_t corners_A, size_t corners_B) const {
  const double distance = std::sqrt(batch_.distance_squared[i]), least = 0.5 * band_;
  if (!(distance > least) || !(batch_.gap[i] > least * distance)) return false;
  const Vec3 n_A = Vec3{batch_.way[0][i], batch_.way[1][i], batch_.way[2][i]} / distance;
  const Vec3 n_B = rotate(conjugate(X_AB_before_.q), n_A);
  const Corners &a = corners_A_[corners_A], &b = corners_B_[corners_B];
  const double from = std::max({dot(n_A, a[0]), dot(n_A, a[1]), dot(n_A, a[2])});
  const double to = std::min({dot(n_B, b[0]), dot(n_B, b[1]), dot(n_B, b[2])});
  return to + dot(n_A, X_AB_before_.p) - from > least;
}

bool NearFront::any_near_pair(const Pose& X_AB, double band) {
  if (has_nearest_ && is_finite(X_AB)) {
    const Corners a = corners_of(shape_A_.mesh, nearest_.a);
    if (triangle_distance(a, corners_of(shape_B_.mesh, nearest_.b, X_AB)).distance <= band) {
      return true;
    }
  }
  AnyNear any = find_near_pair(shape_A_, shape_B_, X_AB, band, kBoxesAsked, nearest_);
  if (any == AnyNear::kUnknown && !update(X_AB, band).empty()) {
    nearest_ = near_[0].triangles;
    any = AnyNear::kFound;
  }
  has_nearest_ = any == AnyNear::kFound;
  return has_nearest_;
}

}  // namespace haptic
