// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/box/obb_overlap.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/query/sweep/swept_triangles.h"

namespace haptic {

/// When a moving tool may first touch an object.
struct MeshMeeting {
  double time = 1;         // the surfaces are apart at every earlier time: never late
  bool meets = false;      // false: they are apart along the whole motion
  bool is_proven = false;  // they are within the tolerance there; else nothing more is known
  TrianglePair pair;       // of the object (a) and of the tool (b)
};

/// Continuous collision detection of two triangle meshes, the tool in rigid motion past the object:
/// the earliest time at which a vertex may meet a face, or an edge an edge (Redon, Kheddar,
/// Coquillart 2002). It treats surfaces, not solids: a tool that begins inside is apart until it
/// leaves. The surfaces must be apart at the start: an edge that already passes through a face (see
/// triangle_pairs) goes unnoticed until features meet.
///
/// Traverses both OBB trees at once, over stretches of the motion that are short in proportion to
/// the boxes, earliest first; every meeting found prunes what is later. The pair that met last is
/// tested first (warm start), which only changes by how much, within the tolerance, an answer is
/// early. Works on any triangle soup. Allocates at construction only; the work is bounded by the
/// pairs of triangles.
class SweptMesh {
 public:
  /// The arrays that both shapes view must outlive it.
  SweptMesh(const MeshShape& object, const MeshShape& tool);

  /// For a fixed object; the tolerance [m] is that of swept_pair.h. A motion that is not finite
  /// gives a meeting at 0, unproven.
  MeshMeeting time_of_impact(const RigidMotion& motion, double tolerance);

  /// Tests these pairs only; the caller knows that no others meet.
  MeshMeeting time_of_impact(const RigidMotion& motion, double tolerance,
                             std::span<const TrianglePair> pairs);

 private:
  struct Search;
  void ask(Search& search, const SweptTriangle& swept_tool, const TrianglePair& pair) const;
  void ask_leaves(Search& search, const ObbNode& a, const ObbNode& b) const;
  void descend(Search& search) const;
  double lever_of(const RigidMotion& motion) const;
  int stretches_of(const RigidMotion& motion) const;

  MeshShape object_, tool_;
  FeatureOwners object_owners_, tool_owners_;
  double reach_;      // bound of all coordinates of both shapes [m]
  double leaf_size_;  // sum of the mean leaf diagonals of both shapes [m]
  std::optional<TrianglePair> witness_;
};

}  // namespace haptic
