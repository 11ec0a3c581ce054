// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/detect/body/cluster_pushes.h"
#include "contact/query/proximity/triangle_pairs.h"

namespace haptic {

/// At most so many pushes of one pair: the corners of one triangle.
inline constexpr size_t kPushesPerPair = 3;

/// What the pairs (a: of the object, b: of the tool) push with, in O, each of `stiffness`, always
/// from object to tool. Of three ways out of a pair the shortest:
///   the object's face, normal n through f: r = max n·(f − p) over the points p of the tool's
///     triangle in the prism over the face, out along n;
///   the tool's face: the same of the object's triangle, out along −n;
///   an edge of each, u and v, that pass each other with both triangles behind: along n = ±u ×
///   v/|…|
///     by the distance of the two lines.
/// A face pushes at each corner of the other triangle that lies in the prism behind it, by that
/// corner's depth n·(f − p), or where none does, at the deepest point there; edges push where they
/// pass. So depth begins at 0 where two triangles begin to meet, and is as local as they are small;
/// it ends in a step where one has passed through: the way of direct rendering. The same corner
/// behind one plane, the same two edges push once, whatever the number of pairs. Sorted by place:
/// the numbering of triangles does not matter. Writes at most pushes.size(), for which
/// kPushesPerPair · pairs.size() is always enough, and returns how many there are. Formula of our
/// own: the three kinds of axes between two convex bodies (Gottschalk, Lin, Manocha 1996), kept to
/// where the triangles are.
size_t pushes_from_pairs(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT,
                         std::span<const TrianglePair> pairs, double stiffness,
                         std::span<PointPush> pushes);

struct ExactOptions {
  double stiffness = 1000;  // of a push, and of a cluster [N/m]
  ClusterOptions clusters;
};

/// Room for what is between the query and its answer, so that a step allocates nothing.
struct ExactScratch {
  std::span<TrianglePair> pairs;
  std::span<PointPush> pushes;  // kPushesPerPair for each pair
};

struct ExactAnswer {
  size_t n_pairs = 0;     // that meet, whether there was room or not
  size_t n_pushes = 0;    // in the scratch, before clustering
  size_t n_clusters = 0;  // written
  size_t left_out = 0;    // pairs without room: their pushes are missing
};

/// All triangles of the tool that meet triangles of the object, as a few contacts:
/// pushes_from_pairs and cluster_pushes, in O. Each cluster has the stiffness of one push and the
/// mean push of its points as depth: what is felt depends on how many places touch, not on how
/// finely they are meshed.
ExactAnswer exact_contacts(const MeshShape& object, const MeshShape& tool, const Pose& X_OT,
                           const ExactOptions& options, const ExactScratch& scratch,
                           std::span<PushCluster> clusters);

}  // namespace haptic
