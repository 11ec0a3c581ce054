// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_front.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRaise = 0.5;    // least share of the children's slack that a parent must keep
constexpr double kWays = 8;       // a slack of so many steps like the last one suffices, too
constexpr double kLeave = 2;      // bands between leaves before one plane replaces their bounds
constexpr size_t kPasses = 512;   // updates in which each pair is tested once for merging
constexpr double kMostWay = 1e3;  // [m]; a longer step rebuilds the front: floats become too coarse
constexpr double kAxes = 1e-5;    // relative error of axes in float

std::vector<Corners> corners_in_order(const MeshShape& shape) {
  std::vector<Corners> corners;
  corners.reserve(shape.tree.order.size());
  for (const uint32_t t : shape.tree.order) corners.push_back(corners_of(shape.mesh, t));
  return corners;
}

double reach_of(const MeshShape& shape) {
  double squared = 0;
  for (const Vec3& v : shape.mesh.vertices) squared = std::max(squared, norm_squared(v));
  return std::sqrt(squared);
}

Vec3 to_vec(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// Largest coordinate along a unit vector among the corners of a leaf, in the frame of its mesh.
double furthest(const std::vector<Corners>& corners, const ObbNode& leaf, const Vec3& way) {
  double most = -std::numeric_limits<double>::infinity();
  for (uint32_t k = 0; k < leaf.count; ++k) {
    const Corners& c = corners[leaf.first + k];
    most = std::max({most, dot(way, c[0]), dot(way, c[1]), dot(way, c[2])});
  }
  return most;
}

double radius_of(const std::vector<Corners>& corners, const ObbNode& leaf, const Vec3& centre) {
  double squared = 0;
  for (uint32_t k = 0; k < leaf.count; ++k) {
    for (const Vec3& p : corners[leaf.first + k]) {
      squared = std::max(squared, norm_squared(p - centre));
    }
  }
  return std::sqrt(squared);
}

}  // namespace

NearFront::NearFront(const MeshShape& shape_A, const MeshShape& shape_B)
    : shape_A_(shape_A),
      shape_B_(shape_B),
      corners_A_(corners_in_order(shape_A)),
      corners_B_(corners_in_order(shape_B)),
      reach_B_(reach_of(shape_B)) {}

std::span<const NearPair> NearFront::update(const Pose& X_AB, double band) {
  suspects_.clear();
  work_ = {};
  const bool is_band = std::isfinite(band) && band >= 0;
  if (corners_B_.empty() || corners_A_.empty() || !is_finite(X_AB) || !is_band) return {};
  if (!is_fresh_ && X_AB == X_AB_ && band <= band_) return nearer_than(band);
  near_.clear();
  X_AB_before_ = std::exchange(X_AB_, X_AB);
  change_ = PoseChange(X_AB_before_, X_AB_, reach_B_);
  boxes_before_ = std::exchange(boxes_, BoxDistance(X_AB));
  band_ = band;
  if (is_fresh_ || !(change_.most({}, reach_B_) < kMostWay)) {
    begin();
  } else {
    planes_.move(change_, band_, expired_);
    move_leaves();
    visit_expired();
    close_some();
  }
  measure_waiting();
  retire();
  return near_;
}

/// The near pairs of the current pose, for a band that is no wider.
std::span<const NearPair> NearFront::nearer_than(double band) {
  if (band < band_) std::erase_if(near_, [&](const NearPair& p) { return p.at.distance > band; });
  band_ = band;
  return near_;
}

std::span<const NearPair> NearFront::follow(const RigidMotion& motion, const Pose& X_AB,
                                            double band) {
  // bounds kept for a narrower band say too little about the motion
  if (!is_fresh_ && band > band_) update(X_AB_, band);
  HAPTIC_ASSERT(sweep_ == nullptr);
  const ObbSweep sweep = sweep_between(motion, 0, 1);
  sweep_ = &sweep;
  const std::span<const NearPair> near = update(X_AB, band);
  sweep_ = nullptr;
  return near;
}

void NearFront::begin() {
  pairs_.assign(2, {});
  planes_.clear();
  bounds_.clear();
  unused_.clear();
  is_fresh_ = false;
  open(0);
}

/// Nodes freed in this update may be reused: nothing refers to them any more.
void NearFront::retire() {
  unused_.insert(unused_.end(), retired_.begin(), retired_.end());
  retired_.clear();
}

/// Moves the bounds of all leaf pairs; queues the triangles that may be near now or, in follow(),
/// were at the previous pose.
void NearFront::move_leaves() {
  const double before = sweep_ != nullptr ? band_ : -std::numeric_limits<double>::infinity();
  looked_at_.clear();
  move_along(bounds_, change_, band_, before, looked_at_);
  constexpr size_t kNodesAhead = 8, kCornersAhead = 4;
  const auto ahead = [&](size_t i) {
    return pairs_[looked_at_[std::min(i, looked_at_.size() - 1)]].nodes;
  };
  for (size_t i = 0; i < looked_at_.size(); ++i) {
    __builtin_prefetch(&node_a(ahead(i + kNodesAhead)));
    __builtin_prefetch(&node_b(ahead(i + kNodesAhead)));
    prefetch_corners(ahead(i + kCornersAhead));
    ask(bounds_[pairs_[looked_at_[i]].below]);
  }
}

/// Amortised coarsening: tests 1/512 of the front per update for merging into the parent. Runs
/// backwards: the entry that replaces a removed one has been tested already.
void NearFront::close_some() {
  const auto some_of = [](size_t n, size_t& asked, const auto& ask) {
    const size_t end = n - std::min(n, asked), most = n / kPasses + 1;
    for (size_t i = end; i-- > end - std::min(end, most);) ask(i);
    asked = asked + most < n ? asked + most : 0;
  };
  some_of(bounds_.size(), n_leaves_asked_, [&](size_t i) {
    if (bounds_[i].asked == 0) leave_leaves(bounds_[i].pair);
  });
  some_of(planes_.size(), n_planes_asked_, [&](size_t i) {
    const uint32_t index = planes_.owner(std::min(i, planes_.size() - 1));
    const auto of_parent = close(index, planes_.gap(index));
    if (of_parent) raise(pairs_[index].parent, *of_parent);
  });
}

/// The front exceeds the caches, so entries are prefetched.
void NearFront::visit_expired() {
  constexpr size_t kPairsAhead = 16, kNodesAhead = 8, kCornersAhead = 4;
  const size_t n = expired_.size();
  const auto ahead = [&](size_t i) { return expired_[std::min(i, n - 1)].owner; };
  for (size_t i = 0; i < n; ++i) {
    __builtin_prefetch(&pairs_[ahead(i + kPairsAhead)]);
    planes_.prefetch(ahead(i + kPairsAhead));
    const NodePair soon = pairs_[ahead(i + kNodesAhead)].nodes;
    __builtin_prefetch(&node_a(soon));
    __builtin_prefetch(&node_b(soon));
    prefetch_corners(pairs_[ahead(i + kCornersAhead)].nodes);
    visit(expired_[i].owner, to_vec(expired_[i].normal_A));
  }
  expired_.clear();
}

/// For leaf pairs.
void NearFront::prefetch_corners(const NodePair& nodes) const {
  if (!is_leaves(nodes)) return;
  for (const Corners* corners :
       {&corners_A_[node_a(nodes).first], &corners_B_[node_b(nodes).first]}) {
    const auto* lines = reinterpret_cast<const char*>(corners);
    for (size_t line = 0; line < kLeafTriangles * sizeof(Corners); line += 64) {
      __builtin_prefetch(lines + line);
    }
  }
}

void NearFront::visit(uint32_t index, const Vec3& normal_A) {
  // may have been merged into its parent since
  if (pairs_[index].state != State::kFar) return;
  ++work_.visited;
  const NodePair nodes = pairs_[index].nodes;
  // the bound is conservative for rotations: compute the gap itself first
  const double gap = gap_along(nodes, normal_A, boxes_, X_AB_);
  if (gap > band_) {
    planes_.set_gap(index, gap);
    return;
  }
  const Apart now = apart(nodes);
  if (is_far(nodes, now)) {
    raise(index, now.plane);
  } else {
    planes_.take_out(index);
    open(index);
  }
}

void NearFront::open(uint32_t index) {
  const NodePair nodes = pairs_[index].nodes;
  if (is_leaves(nodes)) {
    pairs_[index].state = State::kLeaves;
    begin_leaves(index);
    return;
  }
  const uint32_t first = new_halves();
  pairs_[index].state = State::kOpen;
  pairs_[index].below = first;
  const std::array<NodePair, 2> halves = opened(nodes, shape_A_.tree, shape_B_.tree);
  for (uint32_t k = 0; k < 2; ++k) {
    pairs_[first + k] = {halves[k], index, kNone, State::kOpen};
  }
  for (uint32_t k = 0; k < 2; ++k) {
    const Apart now = apart(halves[k]);
    is_far(halves[k], now) ? wait_far(first + k, now.plane) : open(first + k);
  }
}

/// New bounds without any knowledge: all triangles are measured.
void NearFront::begin_leaves(uint32_t index) {
  const NodePair nodes = pairs_[index].nodes;
  const ObbNode &a = node_a(nodes), &b = node_b(nodes);
  const Obb box_a = a.box.unpacked(), box_b = b.box.unpacked();
  pairs_[index].below = static_cast<uint32_t>(bounds_.size());
  LeafBounds& bounds = bounds_.emplace_back();
  bounds.begin(a.count, b.count, norm(box_a.half), norm(box_b.half));
  bounds.set_ball(box_b.centre_O, radius_of(corners_B_, b, box_b.centre_O));
  bounds.pair = index;
  ask(bounds);
}

/// Queues the triangles of a leaf pair that must be measured.
void NearFront::ask(const LeafBounds& bounds) {
  const uint32_t index = bounds.pair;
  const unsigned asked = bounds.asked;
  const ObbNode &a = node_a(pairs_[index].nodes), &b = node_b(pairs_[index].nodes);
  // this may free bounds of other pairs, which moves the ones given here
  if (batch_.n + LeafBounds::kPairs > DistanceBatch::kRoom) measure_waiting();
  HAPTIC_ASSERT(n_leaves_ < leaves_.size() &&
                batch_.n + LeafBounds::kPairs <= DistanceBatch::kRoom);
  leaves_[n_leaves_++] = index;
  for (uint32_t k = 0; k < LeafBounds::kPairs; ++k) {
    if ((asked >> k & 1u) == 0) continue;
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
    const Vec3 way_A{batch_.way[0][i], batch_.way[1][i], batch_.way[2][i]};
    bounds.set(k, per_length * way_A, per_length * batch_.gap[i]);
    double suspect = band_;
    if (sweep_ != nullptr) {
      suspect += change_.most(to_vec(bounds.centre_B), static_cast<double>(bounds.radius));
    }
    if (distance2 > suspect * suspect) continue;
    const size_t a = node_a(pair.nodes).first + k % kLeafTriangles;
    const size_t b = node_b(pair.nodes).first + k / kLeafTriangles;
    const TrianglePair triangles{shape_A_.tree.order[a], shape_B_.tree.order[b]};
    if (sweep_ != nullptr && !was_apart(i, a, b)) suspects_.push_back(triangles);
    if (distance2 <= band_ * band_) near_.push_back({triangles, measured(batch_, i)});
  }
  batch_.n = 0;
  // every leaf pair queued since the last call has been measured
  for (size_t i = 0; i < n_leaves_; ++i) leave_leaves(leaves_[i]);
  n_leaves_ = 0;
}

/// Replaces the bounds of a leaf pair by one plane, normal to the direction of its nearest
/// triangles, if its gap is nearly as large.
void NearFront::leave_leaves(uint32_t index) {
  const Pair& pair = pairs_[index];
  HAPTIC_ASSERT(pair.state == State::kLeaves);
  const LeafBounds& bounds = bounds_[pair.below];
  const size_t nearest = bounds.nearest();
  const auto least = static_cast<double>(bounds.at_least[nearest]);
  if (!(least > kLeave * band_)) return;
  const Vec3 normal_A = SlidingPlanes::rounded(bounds.way_A(nearest));
  const double gap = gap_along(pair.nodes, normal_A, boxes_, X_AB_);
  if (!(gap > band_ && gap > kRaise * least)) return;
  const SlidingPlane plane{normal_A, gap, to_vec(bounds.centre_B),
                           static_cast<double>(bounds.radius)};
  end_leaves(index);
  raise(index, plane);
}

/// Frees the bounds of a leaf pair; the last ones take their place.
void NearFront::end_leaves(uint32_t index) {
  HAPTIC_ASSERT(pairs_[index].state == State::kLeaves);
  const uint32_t below = pairs_[index].below;
  pairs_[bounds_.back().pair].below = below;
  bounds_[below] = bounds_.back();
  bounds_.pop_back();
}

/// Merges the pair and its sibling into their parent, and so on upwards.
void NearFront::raise(uint32_t index, SlidingPlane plane) {
  for (auto of_parent = close(index, plane.gap); of_parent; of_parent = close(index, plane.gap)) {
    index = pairs_[index].parent;
    plane = *of_parent;
  }
  wait_far(index, plane);
}

/// Removes a pair and its sibling if the parent's slack is at least kRaise of theirs, or kWays
/// steps like the last one. Returns the parent's plane.
std::optional<SlidingPlane> NearFront::close(uint32_t index, double gap) {
  if (index == 0 || pairs_[index ^ 1].state != State::kFar) return {};
  const double left = kRaise * (gap - band_);
  if (planes_.gap(index ^ 1) - band_ < left) return {};
  const NodePair& parent = pairs_[pairs_[index].parent].nodes;
  const Apart now = apart(parent);
  const double ways = kWays * change_.most(now.plane.centre_B, now.plane.radius);
  // the sibling may not have been tested since the previous pose, so is_far must hold
  if (now.plane.gap - band_ <= std::min(left, ways) || !is_far(parent, now)) return {};
  for (const uint32_t half : {index, index ^ 1}) {
    if (planes_.has(half)) planes_.take_out(half);
    pairs_[half].state = State::kUnused;
  }
  retired_.push_back(index & ~1u);
  return now.plane;
}

void NearFront::wait_far(uint32_t index, const SlidingPlane& plane) {
  HAPTIC_ASSERT(index < pairs_.size());
  pairs_[index].state = State::kFar;
  planes_.put(index, plane);
}

uint32_t NearFront::new_halves() {
  if (unused_.empty()) {
    pairs_.resize(pairs_.size() + 2);
    return static_cast<uint32_t>(pairs_.size() - 2);
  }
  const uint32_t first = unused_.back();
  unused_.pop_back();
  return first;
}

bool NearFront::is_leaves(const NodePair& nodes) const {
  return node_a(nodes).count > 0 && node_b(nodes).count > 0;
}

NearFront::Apart NearFront::apart(const NodePair& nodes) {
  ++work_.boxes;
  const CompactObb &a = node_a(nodes).box, &b = node_b(nodes).box;
  const BoxDistance::Separation boxes = boxes_.separation(a, b);
  Apart result{boxes.at_least, {}};
  if (!(boxes.at_least > band_)) return result;
  SlidingPlane& plane = result.plane;
  plane.normal_A = SlidingPlanes::rounded(boxes.way_A);
  plane.gap = gap_along(nodes, plane.normal_A, boxes_, X_AB_);
  const Obb box = b.unpacked();
  plane.centre_B = box.centre_O;
  plane.radius = (1 + kAxes) * norm(box.half);
  return result;
}

/// Gap along a unit vector [m]: of the triangles of two leaves, of the boxes of other nodes.
double NearFront::gap_along(const NodePair& nodes, const Vec3& normal_A, const BoxDistance& boxes,
                            const Pose& X_AB) const {
  const ObbNode &a = node_a(nodes), &b = node_b(nodes);
  if (!is_leaves(nodes)) return boxes.along(normal_A, a.box, b.box);
  const Vec3 normal_B = rotate(conjugate(X_AB.q), normal_A);
  return dot(normal_A, X_AB.p) - furthest(corners_B_, b, -normal_B) -
         furthest(corners_A_, a, normal_A);
}

/// Whether two nodes are farther apart than the band and, in follow(), stayed apart along the
/// motion: none of their points moved that far, the same plane separated them before, or the swept
/// boxes do not meet.
bool NearFront::is_far(const NodePair& nodes, const Apart& apart) const {
  if (!(apart.plane.gap > band_)) return false;
  if (sweep_ == nullptr) return true;
  const SlidingPlane& plane = apart.plane;
  return apart.at_least > band_ + change_.most(plane.centre_B, plane.radius) ||
         gap_along(nodes, plane.normal_A, boxes_before_, X_AB_before_) > 0.5 * band_ ||
         !boxes_may_meet(node_a(nodes).box, node_b(nodes).box, *sweep_);
}

/// Whether the same direction separated two measured triangles at the previous pose: then they were
/// apart all along. False does not prove that they met.
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

}  // namespace haptic
