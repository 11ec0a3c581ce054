// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/box/rigid_motion.h"
#include "contact/shape/tree/obb_tree.h"

namespace haptic {

/// A mesh B at rest in A, or the stretch of its motion around a pose: every point of it is within
/// its velocity's way there, give or take what the turn bends it.
struct ObbSweep {
  Mat3 R_AB;  // half-way
  Vec3 p_AB;
  Vec3 centre_A;       // of the turn, half-way
  Vec3 way_A, turn_A;  // from half-way to the end: of the centre [m], about it [rad]
  double angle = 0;    // |turn_A|
};

ObbSweep at_rest(const Pose& X_AB);
/// Of the tool T (B) past the object O (A), between two times.
ObbSweep sweep_between(const RigidMotion& motion, double from, double to);

/// When two bodies may have a point in common, in halves of the sweep: −1 at its start, 1 at its
/// end.
struct SweepWindow {
  double enter = -1, leave = 1;

  bool is_empty() const { return enter > leave; }
};

/// The times at which a box of A and one of B may meet. No triangle in one meets a triangle in the
/// other at any other time; boxes that are apart by 1e-5 of their size may be said to meet. Along
/// each of the 15 separating axes of Gottschalk, Lin, Manocha 1996, as they are half-way, the boxes
/// are apart while |t·L + s d·L| > reach + ρ|θ| + r θ²/2, with d the way of b's centre, ρ half its
/// diagonal, r its largest distance from the centre of the turn: what Taylor's rule leaves of the
/// motion in place of intervals (Redon, Kheddar, Coquillart 2002). Where b turns much their spheres
/// are asked first.
SweepWindow when_boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep);

/// The same for the spheres around both boxes: they are apart while |c + s d| > ρ_a + ρ_b +
/// r θ²/2, with c the way from centre to centre. A turn of b about its own centre costs nothing.
SweepWindow when_spheres_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep);

/// Whether the boxes may meet at all.
inline bool boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  return !when_boxes_may_meet(a, b, sweep).is_empty();
}

/// A node of each tree, by number.
struct NodePair {
  uint32_t a = 0, b = 0;
};

/// Both halves of the pair: the larger box is opened, a leaf never; not for two leaves.
std::array<NodePair, 2> opened(const NodePair& pair, const ObbTree& tree_A, const ObbTree& tree_B);

/// Pairs that wait in a descent through both trees, each level opening one into two.
inline constexpr size_t kMaxWaitingPairs = 2 * kMaxTreeDepth + 2;

}  // namespace haptic
