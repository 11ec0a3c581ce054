// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "contact/query/convex/convex_contact.h"
#include "contact/shape/convex/piece_tree.h"
#include "proto/math/pose.h"

namespace haptic {

inline constexpr uint32_t kNoFaceAlong = ~0u;

/// How two hulls touch, as it was found at some pose; it is carried along with their surfaces.
struct PieceTouch {
  double hulls = 0;           // gap of the hulls then; below 0: their depth, negated [m]
  Vec3 normal_A;              // unit, from A to B; zero: not known
  Vec3 point_a_A, point_b_B;  // nearest or deepest
  uint32_t face_a = kNoFaceAlong, face_b = kNoFaceAlong;  // the real faces that lie best along n
  bool real = false;  // both points lie on the surfaces, which face each other there
};

/// Asks two pieces with B at X_AB in A.
PieceTouch touch_of(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                    const Pose& X_AB, ConvexPairState& state);

/// The depth of the hulls with B now at X_AB, both surfaces carried along; below 0: apart [m].
double depth_of(const PieceTouch& touch, const Pose& X_AB);

/// A place where two pieces touch, or nearly.
struct PieceContact {
  Vec3 point_a_A, point_b_A;  // on B, and depth · n from there: where they touch, on A
  Vec3 normal_A;              // unit, from A to B
  double depth = 0;           // n·(point_a − point_b); below 0: apart [m]
  uint32_t piece_a = 0, piece_b = 0;
};

/// Most contacts of one pair: the corners of a polygon, thinned.
inline constexpr size_t kMostOfPair = 8;

struct PieceContactOptions {
  double tolerance = 1e-3;  // δ: places farther apart are left out [m]
  double spread = 0;        // of pieces with a larger radius the contact is more than a point [m]
};

/// How the triangles that meet under two pieces push, at the places where they do.
struct LocalDepth {
  double deepest = 0, sum = 0;  // of the depths δ there: the largest, and Σ δ [m]
  Vec3 way_A;                   // Σ δ n, n the way out there, unit, from A to B [m]
  Vec3 places_A;                // Σ δ p, p on B [m²]
};

/// The contacts of a touch with B now at X_AB.
///
/// Presence before depth: two pieces push only where triangles under them meet (`local`), since a
/// hull fills what the surface leaves open. They push by the depth of the hulls, which is the least
/// of all directions, but by no less than the deepest of these places and no more than all of them
/// together; along the normal n of the hulls where that lies on both surfaces and n·way ≥ 0, else
/// along way/|way| at the mean of these places, if they have a way: the way out through a face that
/// only closes a hull is no way out of the object, and a farther one is no deeper. Hulls that are
/// apart approach where both nearest points lie on the surfaces.
///
/// Where nobody knows which triangles meet (`local` null), hulls push whose deepest points lie on
/// both surfaces. The original surface lies within a hull by at most its overhang (0 of a leaf):
/// their depth is that of the hulls less both overhangs, so that no level of detail pushes more
/// than the original surfaces do.
///
/// Two pieces of which one is no larger than `spread` touch at one place, the nearest or deepest.
/// Others touch at the corners of the overlap of the two faces that lie best along the normal, seen
/// along it, each with its own depth, so that a body rests on a plane without tilting. Returns the
/// number of contacts.
size_t piece_contacts(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                      const Pose& X_AB, const PieceTouch& touch, const LocalDepth* local,
                      const PieceContactOptions& options,
                      std::span<PieceContact, kMostOfPair> contacts);

}  // namespace haptic
