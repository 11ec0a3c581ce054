// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/piece_front.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr size_t kPiecePasses = 64;   // updates in which each pair is asked once for merging
constexpr double kPieceRaise = 0.25;  // least share of the children's gap that a parent must keep
constexpr double kStagger = 0.5;      // share of `carry` by which the first ask is earlier
constexpr double kGolden = 0.6180339887498949;  // its multiples, modulo 1, are spread evenly
constexpr double kRise = 1.1;    // of the threshold after an update that was cut short
constexpr double kFall = 0.98;   // of it after one with room to spare
constexpr double kSpare = 0.75;  // share of budget and memory in use, at most, for that
constexpr double kLeast = 1e-6;  // threshold at which the rise from 0 begins [m]
// Asks of a pair from one look for another minimum of its depth to the next: flat pieces have one
// on either side, and where they slide the kept one would soon be the deeper. A pair that is
// carried is asked seldom enough to look each time
constexpr uint32_t kLook = 8;
constexpr uint32_t kOld = 1 << 30;  // an age at which the query looks [asks]

/// Volume of the features that a piece lacks [m³].
double removed_volume(const PieceTree& tree, const Piece& piece) {
  if (piece.n_children == 0) return 0;
  const bool is_surface = piece.level < tree.level_pieces.size();
  if (!is_surface || !(piece.resolution > 0)) return kUnbounded;
  return piece.deviation / (piece.resolution * piece.resolution);
}

/// Area of a piece as its neighbour in contact sees it, at most [m²].
double projected_size(const Piece& piece) {
  return std::min(piece.area, std::numbers::pi * piece.radius * piece.radius);
}

double contact_area(const Piece& a, const Piece& b) {
  return std::max({projected_size(a), projected_size(b), std::numeric_limits<double>::min()});
}

}  // namespace

double haptic_error(const PieceTree& tree_a, const Piece& a, const PieceTree& tree_b,
                    const Piece& b) {
  return std::max(removed_volume(tree_a, a), removed_volume(tree_b, b)) / contact_area(a, b);
}

PieceFront::PieceFront(const PieceTree& tree_a, const PieceTree& tree_b, uint32_t most_nodes)
    : tree_a_(tree_a), tree_b_(tree_b), nodes_(most_nodes) {
  HAPTIC_ASSERT(most_nodes > 0);
  front_.reserve(most_nodes);
  wanted_.reserve(most_nodes);
  contacts_.reserve(size_t{2} * most_nodes + kMostOfPair);
}

void PieceFront::update(const Pose& X_AB, const RefineOptions& options) {
  work_ = 0;
  is_truncated_ = false;
  const bool is_sound = is_finite(X_AB) && std::isfinite(options.tolerance) &&
                        options.tolerance >= 0 && options.threshold >= 0;
  if (!is_sound || tree_a_.pieces.empty() || tree_b_.pieces.empty()) {
    front_.clear();
    forget();
    return;
  }
  options_ = options;
  threshold_ = is_fresh_ ? options.threshold : std::max(threshold_, options.threshold);
  if (is_fresh_) {
    X_AB_ = X_AB;
    begin();
  } else {
    move_marks(X_AB);
    test_marked();
  }
  reach_ = options.tolerance;
  is_fresh_ = false;
  refine();
  close_some();
  // what the last contacts had no room for counts now
  if (is_truncated_ || std::exchange(lacks_room_, false)) {
    threshold_ = std::max(kRise * threshold_, kLeast);
  } else if (threshold_ > options.threshold && work_ < kSpare * options.budget &&
             static_cast<double>(front_.size()) < kSpare * static_cast<double>(nodes_.size())) {
    threshold_ = std::max(kFall * threshold_, options.threshold);
    if (threshold_ < kLeast) threshold_ = options.threshold;
  }
}

bool PieceFront::overlaps() const {
  return std::any_of(front_.begin(), front_.end(), [&](const Mark& mark) {
    const Node& node = nodes_[mark.node];
    // of what was not tested nothing is known
    if (node.state != State::kNear) return mark.gap <= 0;
    const double inside = piece_a(node).hull_distance + piece_b(node).hull_distance;
    return depth_of(node.touch, X_AB_) > -(inside + options_.carry);
  });
}

size_t PieceFront::near() const {
  return static_cast<size_t>(std::count_if(front_.begin(), front_.end(), [&](const Mark& mark) {
    return nodes_[mark.node].state == State::kNear;
  }));
}

/// Starts with the pair of the roots.
void PieceFront::begin() {
  front_.clear();
  wanted_.clear();
  asked_ = rotation_ = 0;
  n_unused_ = static_cast<uint32_t>(nodes_.size());
  for (uint32_t i = 0; i < n_unused_; ++i) {
    nodes_[i].state = State::kUnused;
    nodes_[i].beside = i + 1 < n_unused_ ? i + 1 : kNone;
  }
  unused_ = 0;
  const uint32_t root = new_node(0, 0, kNone);
  if (options_.budget == 0) {
    is_truncated_ = true;
    return;
  }
  test(root);
}

/// Consumes the gaps of the far pairs by the motion of the pieces of B.
void PieceFront::move_marks(const Pose& X_AB) {
  const Mat3 before = to_matrix(X_AB_.q), now = to_matrix(X_AB.q);
  Mat3 turn;
  for (int i = 0; i < 3; ++i) turn.row[i] = now.row[i] - before.row[i];
  // ‖R' − R‖ of a rotation: twice the sine of half its angle, at most the norm of the difference
  const double angle = std::sqrt(
      0.5 * (norm_squared(turn.row[0]) + norm_squared(turn.row[1]) + norm_squared(turn.row[2])));
  const Vec3 way = X_AB.p - X_AB_.p;
  const double wider = std::max(options_.tolerance - reach_, 0.0);
  for (Mark& mark : front_) {
    mark.gap -= norm(way + turn * mark.centre_B) + angle * mark.radius + wider;
  }
  X_AB_ = X_AB;
}

/// Tests the pairs whose gap is consumed, as far as the budget allows.
void PieceFront::test_marked() {
  const size_t n = front_.size();
  HAPTIC_ASSERT(n > 0);
  const size_t first = rotation_ % n;
  for (size_t k = 0; k < n; ++k) {
    const size_t at = first + k < n ? first + k : first + k - n;
    if (front_[at].gap > 0) continue;
    if (work_ >= options_.budget) {
      is_truncated_ = true;
      rotation_ = at;
      return;
    }
    test(front_[at].node);
  }
}

/// Opens pairs, the largest error first.
void PieceFront::refine() {
  while (!wanted_.empty()) {
    std::pop_heap(wanted_.begin(), wanted_.end(),
                  [](const Wanted& a, const Wanted& b) { return a.error < b.error; });
    const uint32_t index = wanted_.back().node;
    wanted_.pop_back();
    if (open(index)) continue;
    is_truncated_ = true;
    wanted_.clear();
  }
}

/// Amortised coarsening: asks a share of the front whether the siblings can be merged.
void PieceFront::close_some() {
  const size_t most = front_.size() / kPiecePasses + 1;
  for (size_t i = 0; i < most; ++i) {
    if (asked_ >= front_.size()) asked_ = 0;
    const uint32_t parent = nodes_[front_[asked_++].node].parent;
    if (parent == kNone || work_ >= options_.budget) continue;
    if (const auto measured = closing(parent)) close(parent, *measured);
  }
}

std::span<const PieceContact> PieceFront::contacts(
    const std::optional<std::span<const TriangleMeeting>>& meetings) {
  contacts_.clear();
  if (meetings) credit(*meetings);
  // pairs that were not tested are carried along
  for (const Mark& mark : front_) {
    const Node& node = nodes_[mark.node];
    const bool is_near = node.state == State::kNear;
    // triangles that meet push under a pair that the budget left untested as well
    if (!is_near && !(meetings && node.local.sum > 0)) continue;
    std::array<PieceContact, kMostOfPair> found;
    const size_t n = piece_contacts(
        tree_a_, node.a, tree_b_, node.b, X_AB_, is_near ? node.touch : PieceTouch{},
        meetings ? &node.local : nullptr, {options_.tolerance, options_.spread}, found);
    const size_t room = contacts_.capacity() - contacts_.size();
    contacts_.insert(contacts_.end(), found.begin(),
                     found.begin() + static_cast<ptrdiff_t>(std::min(n, room)));
    lacks_room_ |= n > room;
  }
  is_truncated_ |= lacks_room_;
  return contacts_;
}

/// Adds up the places where triangles meet, each for the pair of the front over it.
void PieceFront::credit(std::span<const TriangleMeeting> meetings) {
  for (const Mark& mark : front_) nodes_[mark.node].local = {};
  TriangleMeeting last{kNone, kNone, {}, {}};
  uint32_t node = kNone;
  for (const TriangleMeeting& meeting : meetings) {
    // places that are near often lie under the same pieces
    if (meeting.leaf_a != last.leaf_a || meeting.leaf_b != last.leaf_b) {
      node = over(meeting.leaf_a, meeting.leaf_b);
    }
    last = meeting;
    if (node == kNone) continue;
    LocalDepth& local = nodes_[node].local;
    local.deepest = std::max(local.deepest, meeting.depth);
    local.sum += meeting.share * meeting.depth;
    local.way_A += meeting.share * meeting.depth * meeting.normal_A;
    local.places_A += meeting.share * meeting.depth * meeting.point_A;
  }
}

/// The pair of the front over two leaves: down from the roots.
uint32_t PieceFront::over(uint32_t leaf_a, uint32_t leaf_b) const {
  const auto is_under = [](const PieceTree& tree, uint32_t leaf, uint32_t piece) {
    // children come after their parents
    while (leaf > piece) leaf = tree.pieces[leaf].parent;
    return leaf == piece;
  };
  uint32_t index = front_.empty() ? kNone : 0;
  while (index != kNone && nodes_[index].state == State::kOpen) {
    index = nodes_[index].below;
    while (index != kNone && !(is_under(tree_a_, leaf_a, nodes_[index].a) &&
                               is_under(tree_b_, leaf_b, nodes_[index].b))) {
      index = nodes_[index].beside;
    }
  }
  return index;
}

/// Detail that would be felt as a vibration above the bandwidth.
bool PieceFront::is_left_out(const PieceTree& tree, const Piece& piece) const {
  if (!(options_.bandwidth > 0) || piece.level >= tree.level_pieces.size()) return false;
  return options_.speed * tree.pieces[piece.first_child].resolution > options_.bandwidth;
}

bool PieceFront::may_open(const PieceTree& tree, const Piece& piece, double area) const {
  if (piece.n_children == 0 || is_left_out(tree, piece)) return false;
  return threshold_ == 0 || removed_volume(tree, piece) / area > threshold_;
}

PieceFront::Opening PieceFront::opening_of(const Node& node) const {
  const Piece &a = piece_a(node), &b = piece_b(node);
  const double area = contact_area(a, b);
  const bool opens_a = may_open(tree_a_, a, area), opens_b = may_open(tree_b_, b, area);
  if (!opens_a && !opens_b) return Opening::kNone;
  if (opens_a != opens_b) return opens_a ? Opening::kA : Opening::kB;
  return a.radius >= b.radius ? Opening::kA : Opening::kB;
}

/// Measures a pair: far, or near by its hulls.
PieceFront::Measured PieceFront::measure(Node& node) {
  ++work_;
  const Piece &a = piece_a(node), &b = piece_b(node);
  const double least = options_.tolerance + a.hull_distance + b.hull_distance;
  // the balls are cheap and prune most
  const double balls = norm(X_AB_ * b.centre - a.centre) - a.radius - b.radius;
  if (balls > least) return {State::kFar, balls - least};
  if (options_.carry > 0 || node.coherent.age >= kLook) node.coherent.age = kOld;
  node.touch = touch_of(tree_a_, node.a, tree_b_, node.b, X_AB_, node.coherent);
  if (node.touch.hulls > least) return {State::kFar, node.touch.hulls - least};
  // pairs that were first asked together are asked again in turns
  return {State::kNear, options_.carry * (1 - kStagger * std::fmod(kGolden * work_, 1))};
}

/// Tests a pair of the front; a near one that should be refined is queued.
void PieceFront::test(uint32_t index) {
  Node& node = nodes_[index];
  HAPTIC_ASSERT(node.place != kNone);
  const Measured now = measure(node);
  node.state = now.state;
  front_[node.place].gap = now.gap;
  if (node.state != State::kNear || opening_of(node) == Opening::kNone) return;
  const double error = haptic_error(tree_a_, piece_a(node), tree_b_, piece_b(node));
  wanted_.push_back({error, index});
  std::push_heap(wanted_.begin(), wanted_.end(),
                 [](const Wanted& a, const Wanted& b) { return a.error < b.error; });
}

/// Replaces a pair by those of the children of one piece. False: the budget or the memory ends.
bool PieceFront::open(uint32_t index) {
  const Opening opening = opening_of(nodes_[index]);
  HAPTIC_ASSERT(opening != Opening::kNone);
  const bool is_a = opening == Opening::kA;
  const Piece& piece = is_a ? piece_a(nodes_[index]) : piece_b(nodes_[index]);
  const uint32_t n = piece.n_children;
  if (n > n_unused_ || n > options_.budget - std::min(work_, options_.budget)) return false;
  leave_front(index);
  nodes_[index].state = State::kOpen;
  uint32_t before = kNone;
  for (uint32_t k = 0; k < n; ++k) {
    const uint32_t child = piece.first_child + k;
    const Node& parent = nodes_[index];
    const uint32_t made =
        is_a ? new_node(child, parent.b, index) : new_node(parent.a, child, index);
    (before == kNone ? nodes_[index].below : nodes_[before].beside) = made;
    before = made;
    test(made);
  }
  return true;
}

/// The measure of an open pair that can stand for its children again: all of them are far and so is
/// it, or it would not be refined now.
std::optional<PieceFront::Measured> PieceFront::closing(uint32_t index) {
  double least = kUnbounded;
  bool any_near = false;
  for (uint32_t i = nodes_[index].below; i != kNone; i = nodes_[i].beside) {
    if (nodes_[i].state != State::kFar && nodes_[i].state != State::kNear) return {};
    any_near |= nodes_[i].state == State::kNear;
    least = std::min(least, front_[nodes_[i].place].gap);
  }
  Node& node = nodes_[index];
  if (any_near && opening_of(node) != Opening::kNone) return {};
  const Measured now = measure(node);
  // a parent with hardly a gap would be opened again soon
  if (!any_near && !(now.state == State::kFar && now.gap > kPieceRaise * least)) return {};
  return now;
}

void PieceFront::close(uint32_t index, const Measured& measured) {
  for (uint32_t i = nodes_[index].below; i != kNone;) {
    const uint32_t next = nodes_[i].beside;
    leave_front(i);
    free_node(i);
    i = next;
  }
  nodes_[index].below = kNone;
  nodes_[index].state = measured.state;
  enter_front(index);
  front_.back().gap = measured.gap;
}

uint32_t PieceFront::new_node(uint32_t a, uint32_t b, uint32_t parent) {
  HAPTIC_ASSERT(unused_ != kNone && n_unused_ > 0);
  const uint32_t index = unused_;
  unused_ = nodes_[index].beside;
  --n_unused_;
  nodes_[index] = {};
  nodes_[index].a = a;
  nodes_[index].b = b;
  nodes_[index].parent = parent;
  nodes_[index].state = State::kFar;
  enter_front(index);
  return index;
}

void PieceFront::free_node(uint32_t index) {
  nodes_[index].state = State::kUnused;
  nodes_[index].beside = unused_;
  unused_ = index;
  ++n_unused_;
}

/// Untested: without a gap.
void PieceFront::enter_front(uint32_t index) {
  const Piece& b = piece_b(nodes_[index]);
  nodes_[index].place = static_cast<uint32_t>(front_.size());
  front_.push_back({index, 0, b.centre, b.radius});
}

/// The last pair of the front takes its place.
void PieceFront::leave_front(uint32_t index) {
  const uint32_t place = std::exchange(nodes_[index].place, kNone);
  HAPTIC_ASSERT(place < front_.size());
  front_[place] = front_.back();
  if (front_[place].node != index) nodes_[front_[place].node].place = place;
  front_.pop_back();
}

}  // namespace haptic
