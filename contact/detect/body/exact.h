// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/detect/body/cluster_pushes.h"
#include "contact/query/proximity/triangle_pairs.h"

namespace haptic {

/// Most pushes of one pair: the corners of one triangle.
inline constexpr size_t kPushesPerPair = 3;

/// Least cosine between normals of pushes at one point that are one push.
inline constexpr double kOnePlane = 1 - 1e-9;

/// How two triangles that meet push.
struct PairPushes {
  double depth = 0;  // of the shortest way that separates them [m]
  size_t n = 0;      // 0: none of the ways holds
  std::array<PointPush, kPushesPerPair> pushes;
};

/// The pushes of a pair of triangles that meet (a: of the object, b: of the tool), in O, each of
/// `stiffness` [N/m], from object to tool. Of three ways to separate it the shortest is taken:
///   the object's face, normal n through f: r = max n·(f − p) over the points p of the tool's
///     triangle within the prism over the face, out along n;
///   the tool's face: the same for the object's triangle, out along −n;
///   one edge of each, u and v, that cross with both triangles behind: along n = ±u × v/|…|
///     by the distance of the two lines.
/// A face pushes at each corner of the other triangle that lies behind it within the prism, with
/// that corner's depth n·(f − p), else at the deepest point there; edges push where they cross. So
/// depth begins at 0 where two triangles begin to meet, and ends with a jump where one has passed
/// through, as always in direct rendering. Our own formula, from the separating axes of two convex
/// bodies (Gottschalk, Lin, Manocha 1996), restricted to where the triangles are.
PairPushes pushes_of_pair(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT,
                          const TrianglePair& pair, double stiffness);

/// The pushes of all pairs. The same corner behind the same plane, or the same two edges, push
/// once, whatever the number of pairs. Sorted by place, so independent of the numbering of
/// triangles. Writes at most pushes.size(), for which kPushesPerPair · pairs.size() suffices, and
/// returns their number.
size_t pushes_from_pairs(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT,
                         std::span<const TrianglePair> pairs, double stiffness,
                         std::span<PointPush> pushes);

/// How the places where triangles or pieces touch push.
struct PushOptions {
  double stiffness = 1000;  // of a push [N/m]
  double sharing = 4;       // pushes from which on they share it: the corners of a box
  ClusterOptions clusters;
};

/// Buffers between the query and its answer, so that a step allocates nothing.
struct ExactScratch {
  std::span<TrianglePair> pairs;
  std::span<PointPush> pushes;  // kPushesPerPair for each pair
};

struct ExactAnswer {
  size_t n_pairs = 0;     // pairs that meet, including those without room
  size_t n_pushes = 0;    // in the scratch, before clustering
  size_t n_clusters = 0;  // written
  size_t left_out = 0;    // pairs without room: their pushes are missing
};

/// All triangles of the tool that meet triangles of the object, as a few contacts:
/// pushes_from_pairs, share_stiffness and cluster_pushes, in O. From `sharing` pushes on the force
/// does not depend on their number, that is, on the resolution of the mesh.
ExactAnswer exact_contacts(const MeshShape& object, const MeshShape& tool, const Pose& X_OT,
                           const PushOptions& options, ClusterMemory& memory,
                           const ExactScratch& scratch, std::span<PushCluster> clusters);

}  // namespace haptic
