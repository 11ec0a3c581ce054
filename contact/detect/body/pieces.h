// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "contact/detect/body/body_question.h"
#include "contact/detect/body/exact.h"
#include "contact/query/convex/piece_front.h"

namespace haptic {

/// Constant data of the detector of convex pieces, of the renderers localized and sensation.
struct PieceModel : PushOptions {
  PieceTree tool;                  // in T
  std::vector<PieceTree> objects;  // each in its O
  RefineOptions refine;            // of sensation; localized goes down to every piece
  double search = 0;       // distance within which a cluster's place on a surface is sought [m]
  double tool_radius = 0;  // around its origin, for the speed of sliding [m]
  std::vector<uint32_t> most_pairs;  // of pieces in memory, of each object: all, or what fits
};

/// State that survives a step, and its buffers: nothing is allocated later.
struct PieceState {
  explicit PieceState(const PieceModel& model);

  std::vector<PieceFront> fronts;         // of each object
  std::vector<TrianglePair> pairs;        // triangles of one object and the tool that meet,
  std::vector<TriangleMeeting> meetings;  // and where
  std::vector<PointPush> pushes;
  std::vector<ClusterMemory> clusters;  // of each object
  uint64_t tested = 0;                  // pairs of pieces in the last step
};

/// Fills in the contacts of a set by the convex pieces of tool and objects: pairs of pieces whose
/// triangles meet push by their penetration depth, those that are nearer than the reach approach
/// with the depth that they will have, negative until then (Kim, Otaduy, Lin, Manocha 2003), and
/// clusters of them are the contacts, the pushing ones of each object first. `refine` says at which
/// level of detail (Otaduy & Lin 2003); which triangles meet is asked of all of them where hulls
/// overlap, within twice its budget in pairs of boxes and once in pairs of triangles; where that,
/// or the room for 16,384 pairs, does not suffice, hulls push by themselves. Sets kContactTruncated
/// if there was no room, kContactIterationLimit if the budget or the memory ended.
void detect_pieces(const PieceModel& model, const RefineOptions& refine, const BodyMeshes& meshes,
                   PieceState& state, const BodyQuestion& question, ContactSet& set);

}  // namespace haptic
