// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact/query/convex/piece_contact.h"
#include "contact/shape/convex/piece_tree.h"
#include "proto/math/pose.h"

namespace haptic {

/// When a pair of pieces is replaced by the pairs of its children.
struct RefineOptions {
  double threshold = 0;          // s0: pairs with a larger haptic error are refined [m]; 0: all
  double tolerance = 1e-3;       // δ: surfaces nearer than this are reported [m]
  double carry = 0;              // a near pair is asked again once it has moved this far [m]
  double spread = 0;             // as in PieceContactOptions [m]
  double speed = 0;              // at which the surfaces slide [m/s]
  double bandwidth = 0;          // detail that slides past more often is left out [Hz]; 0: none
  uint32_t budget = 0xffffffff;  // node pairs tested per update
};

/// The haptic error s* of rendering two pieces at their own level of detail [m]: the volume of the
/// features that were removed from either, φ = deviation / resolution², over the area D of the
/// contact, here the projected size of the larger piece: s* = max(φ_a, φ_b) / D (Otaduy & Lin
/// 2003). Infinite for a piece above the coarsest level, which is a bounding volume only.
double haptic_error(const PieceTree& tree_a, const Piece& a, const PieceTree& tree_b,
                    const Piece& b);

/// A place where triangles meet, one of each surface, and of which leaf pieces they are.
struct TriangleMeeting {
  uint32_t leaf_a = 0, leaf_b = 0;
  Vec3 point_A, normal_A;  // n: the way out, unit, from A to B
  double depth = 0;        // δ: how deep they are in each other there [m]
  double share = 1;        // of the place, where several pairs of triangles meet
};

/// The contacts of two surfaces by their contact levels of detail (Otaduy & Lin 2003): keeps the
/// front of the traversal of the bounding-volume test tree, whose nodes are pairs of pieces.
///
/// Pruning: a pair farther apart than δ + h_a + h_b, h the Hausdorff distances of the hulls to
/// those of their leaves, is not refined. Refinement: a nearer pair is replaced by pairs of
/// children of the larger piece while s* exceeds s0, the largest s* first; with s0 = 0 down to the
/// leaves, which is the exact query. Detail of resolution r that slides past at the speed v
/// has the frequency v·r [Hz]; beyond the bandwidth it is not refined. Where the refinement ends,
/// the pair's own hulls give the contacts.
///
/// Time-critical: the budget counts tests of node pairs and is never exceeded; when it or the
/// memory ends, is_truncated() is set, the pairs that were not tested are carried along with their
/// surfaces as they were measured last, and the threshold in force rises until the front fits, then
/// falls back to s0.
///
/// Temporal coherence: each pair of the front keeps the state of its convex query; a far one is not
/// tested again before the motion has consumed its gap (generalised front tracking, Ehmann & Lin
/// 2001), a near one not before it has moved by `carry` since it was tested: until then its contact
/// is carried along with both surfaces, its normal with A. All memory is taken at construction.
class PieceFront {
 public:
  /// The arrays that both trees view must outlive it. `most_nodes`: node pairs in memory.
  PieceFront(const PieceTree& tree_a, const PieceTree& tree_b, uint32_t most_nodes);

  /// Moves B to X_AB in A and refines the front. Forgets all pairs for a pose that is not finite.
  void update(const Pose& X_AB, const RefineOptions& options);

  /// Returns whether leaves under any pair of the front may overlap; triangles meet only then.
  bool overlaps() const;

  /// The contacts after an update (piece_contacts), in A, in unspecified order, valid until the
  /// next call. `meetings`: all of the two meshes at that pose, each of which counts for the pair
  /// of the front over it; none: too many to be known.
  std::span<const PieceContact> contacts(
      const std::optional<std::span<const TriangleMeeting>>& meetings);

  /// Discards the front: the next update starts from the roots.
  void forget() { is_fresh_ = true; }

  bool is_truncated() const { return is_truncated_; }
  /// Room for contacts.
  size_t most_contacts() const { return contacts_.capacity(); }
  /// Node pairs tested in the last update.
  uint32_t work() const { return work_; }
  /// Pairs of the front, and those of them that are near.
  size_t size() const { return front_.size(); }
  size_t near() const;
  double threshold() const { return threshold_; }  // in force [m]

 private:
  static constexpr uint32_t kNone = ~0u;

  enum class State : uint8_t { kUnused, kFar, kNear, kOpen };
  enum class Opening : uint8_t { kNone, kA, kB };
  struct Node {
    uint32_t a = 0, b = 0;  // pieces
    uint32_t parent = kNone;
    uint32_t below = kNone;   // open: its first child
    uint32_t beside = kNone;  // the next child of its parent; unused: the next unused node
    uint32_t place = kNone;   // in the front
    State state = State::kUnused;
    ConvexPairState coherent;  // of the query of its hulls
    PieceTouch touch;          // near: as asked last
    LocalDepth local;          // near: of the triangles that meet under it
  };
  /// A pair of the front: what every update looks at.
  struct Mark {
    uint32_t node;
    double gap;     // motion before it is tested again: far: beyond δ + h_a + h_b [m]
    Vec3 centre_B;  // ball of the piece of B
    double radius;  // [m]
  };
  struct Measured {
    State state;
    double gap;  // as in Mark
  };
  struct Wanted {
    double error;  // s* [m]
    uint32_t node;
  };

  void begin();
  void move_marks(const Pose& X_AB);
  void test_marked();
  void refine();
  void close_some();
  void credit(std::span<const TriangleMeeting> meetings);
  uint32_t over(uint32_t leaf_a, uint32_t leaf_b) const;
  bool is_left_out(const PieceTree& tree, const Piece& piece) const;
  bool may_open(const PieceTree& tree, const Piece& piece, double area) const;
  Opening opening_of(const Node& node) const;
  Measured measure(Node& node);
  void test(uint32_t index);
  bool open(uint32_t index);
  std::optional<Measured> closing(uint32_t index);
  void close(uint32_t index, const Measured& measured);
  uint32_t new_node(uint32_t a, uint32_t b, uint32_t parent);
  void free_node(uint32_t index);
  void enter_front(uint32_t index);
  void leave_front(uint32_t index);
  const Piece& piece_a(const Node& node) const { return tree_a_.pieces[node.a]; }
  const Piece& piece_b(const Node& node) const { return tree_b_.pieces[node.b]; }

  PieceTree tree_a_, tree_b_;
  std::vector<Node> nodes_;
  std::vector<Mark> front_;
  std::vector<Wanted> wanted_;  // heap: the largest error on top
  std::vector<PieceContact> contacts_;
  uint32_t unused_ = kNone;  // first of the unused nodes
  uint32_t n_unused_ = 0;
  uint32_t work_ = 0;
  size_t asked_ = 0;     // cursor of the amortised coarsening
  size_t rotation_ = 0;  // where testing begins: nothing is left untested for ever
  double threshold_ = 0;
  RefineOptions options_;
  Pose X_AB_;
  double reach_ = 0;  // δ of the previous update [m]
  bool is_fresh_ = true, is_truncated_ = false, lacks_room_ = false;
};

}  // namespace haptic
