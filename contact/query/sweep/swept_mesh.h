// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/box/obb_overlap.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/query/sweep/swept_triangles.h"

namespace haptic {

/// When a tool that moves may first touch an object.
struct MeshMeeting {
  double time = 1;         // the surfaces are apart at any time before: never late
  bool meets = false;      // false: they are apart all the way
  bool is_proven = false;  // within the tolerance of each other there, to a tolerance of time;
                           // else the budget of a pair of features has ended its search
  TrianglePair pair;       // of the object (a) and of the tool (b), that may meet first
};

/// Continuous collision of two triangle meshes, the tool in rigid motion past the object: the
/// earliest time at which a vertex may meet a face or an edge an edge (Redon, Kheddar, Coquillart
/// 2002). Surfaces, not bodies: a tool that begins inside is apart until it leaves. They are to be
/// apart at first: where an edge passes through a face already (triangle_pairs tells), that is not
/// seen until features meet.
///
/// Both OBB trees at once, over stretches of the motion that are short beside the boxes, earliest
/// first; every meeting ends the time that is still asked about, for all that follows; the pair
/// that met last time is asked first, which may only change by how much within the tolerance an
/// answer is early. Works on any soup of triangles. Allocates only when it is
/// made; bounded by the number of pairs of triangles and the budget of each pair of features.
class SweptMesh {
 public:
  /// Views: both shapes must outlive this.
  SweptMesh(const MeshShape& object, const MeshShape& tool);

  /// Of the tool along the motion, with the object still. A motion that is not finite meets at 0,
  /// unproven.
  MeshMeeting time_of_impact(const RigidMotion& motion, const SweptPairOptions& options);

  /// The same among these pairs alone, where others are known not to meet.
  MeshMeeting time_of_impact(const RigidMotion& motion, const SweptPairOptions& options,
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
  double reach_;      // no coordinate of either is larger [m]
  double leaf_size_;  // a typical diagonal of the leaves of both [m]
  std::optional<TrianglePair> witness_;
};

}  // namespace haptic
