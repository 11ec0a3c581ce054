// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "contact/query/convex/convex_contact.h"
#include "contact/shape/convex/piece_tree.h"
#include "proto/math/pose.h"

namespace haptic {

/// How two pieces touch, as it was found at some pose; it is carried along with their surfaces.
struct PieceTouch {
  double hulls = 0;                 // gap of the hulls then; below 0: their depth, negated [m]
  Vec3 normal_A;                    // unit, from A to B
  Vec3 point_a_A, point_b_B;        // nearest or deepest
  uint32_t face_a = 0, face_b = 0;  // the real faces that lie best along the normal
  bool is_contact = false;          // both surfaces face each other there
};

/// Asks two pieces with B at X_AB in A. It is no contact where the normal leads out of no real face
/// of either piece, or where no feature near the answer lies on the surface.
PieceTouch touch_of(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                    const Pose& X_AB, ConvexPairState& state);

/// A place where two pieces touch, or nearly.
struct PieceContact {
  Vec3 point_a_A, point_b_A;  // on either surface
  Vec3 normal_A;              // unit, from A to B
  double depth = 0;           // n·(point_a − point_b); below 0: apart [m]
  uint32_t piece_a = 0, piece_b = 0;
  uint32_t triangle_a = kNoTriangle, triangle_b = kNoTriangle;  // of the meshes, near it
};

/// Most contacts of one pair: the corners of a polygon, thinned.
inline constexpr size_t kMostOfPair = 8;

struct PieceContactOptions {
  double tolerance = 1e-3;  // δ: places farther apart are left out [m]
  double spread = 0;        // of pieces with a larger radius the contact is more than a point [m]
};

/// The contacts of a touch with B now at X_AB. Of two pieces of which one is no larger than
/// `spread`: the nearest or deepest place. Of others the corners of the overlap of the two faces,
/// as seen along the normal, with the depth of each, so that a body rests on a plane without
/// tilting. The original surface lies within a hull by at most its overhang (0 of a leaf): each
/// depth is that of the hulls less both overhangs, so that no level of detail, and no pair that a
/// budget left coarse, pushes more than the original surfaces do. Returns their number.
size_t piece_contacts(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                      const Pose& X_AB, const PieceTouch& touch, const PieceContactOptions& options,
                      std::span<PieceContact, kMostOfPair> contacts);

}  // namespace haptic
