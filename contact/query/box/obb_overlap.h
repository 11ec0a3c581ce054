// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/box/rigid_motion.h"
#include "contact/shape/tree/obb_tree.h"
#include "proto/math/assert.h"

namespace haptic {

/// A mesh B at rest in A, or a stretch of its motion linearised about its middle: each point
/// deviates from its linearised way by no more than the bend of the rotation.
struct ObbSweep {
  Mat3 R_AB;  // in the middle
  Vec3 p_AB;
  Vec3 centre_A;       // of rotation, in the middle
  Vec3 way_A, turn_A;  // from the middle to the end: of the centre [m], about it [rad]
  double angle = 0;    // |turn_A|
};

ObbSweep at_rest(const Pose& X_AB);
/// Sweep of the tool T (as B) past the object O (as A), between two times.
ObbSweep sweep_between(const RigidMotion& motion, double from, double to);

/// When two bodies may have a common point, in half lengths of the sweep: −1 at its start, 1 at its
/// end.
struct SweepWindow {
  double enter = -1, leave = 1;

  bool is_empty() const { return enter > leave; }
};

/// The times at which a box of A and one of B may meet. At any other time no triangle in one meets
/// a triangle in the other; boxes apart by less than 1e-5 of their size may be reported as meeting.
/// Along each of the 15 separating axes L of Gottschalk, Lin, Manocha 1996, taken in the middle,
/// the boxes are apart while |t·L + s d·L| > reach + ρ|θ| + r θ²/2, with d the displacement of b's
/// centre, ρ half its diagonal, and r its largest distance from the centre of rotation: a Taylor
/// bound of the motion instead of interval arithmetic (Redon, Kheddar, Coquillart 2002). If b
/// rotates much, bounding spheres are tested first.
SweepWindow when_boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep);

/// The window for the spheres around both boxes: apart while |c + s d| > ρ_a + ρ_b + r θ²/2,
/// with c the vector between the centres. Rotation of b about its own centre does not matter.
SweepWindow when_spheres_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep);

inline bool boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  return !when_boxes_may_meet(a, b, sweep).is_empty();
}

/// Indices of a node of each tree.
struct NodePair {
  uint32_t a = 0, b = 0;
};

/// Splits the pair in two: opens the larger box, or the one that is not a leaf. Not for two leaves.
std::array<NodePair, 2> opened(const NodePair& pair, const ObbTree& tree_A, const ObbTree& tree_B);

/// Room of the stack in a traversal of both trees: each level replaces one pair by two.
inline constexpr size_t kMaxWaitingPairs = 2 * kMaxTreeDepth + 2;

/// Descends both trees at once, the larger box opened first, where may_meet(box of A, box of B)
/// says so. Calls on_leaves(a, b) for two leaves until it returns false; false: it did.
template <class MayMeet, class OnLeaves>
bool descend_both(const ObbTree& tree_A, const ObbTree& tree_B, const MayMeet& may_meet,
                  const OnLeaves& on_leaves) {
  std::array<NodePair, kMaxWaitingPairs> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = {0, 0};
  while (n_waiting > 0) {
    const NodePair pair = waiting[--n_waiting];
    const ObbNode &a = tree_A.nodes[pair.a], &b = tree_B.nodes[pair.b];
    if (!may_meet(a.box, b.box)) continue;
    if (a.count > 0 && b.count > 0) {
      if (!on_leaves(a, b)) return false;
      continue;
    }
    HAPTIC_ASSERT(n_waiting + 2 <= waiting.size());
    for (const NodePair& half : opened(pair, tree_A, tree_B)) waiting[n_waiting++] = half;
  }
  return true;
}

}  // namespace haptic
