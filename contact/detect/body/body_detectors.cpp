// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/body_detectors.h"

#include <algorithm>
#include <array>
#include <limits>

#include "contact/detect/body/cluster_contact.h"
#include "contact/detect/body/contact_reach.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr uint32_t kMostPiecePairs = 1 << 16;  // in memory, per object
constexpr size_t kMostPairs = 1 << 14;         // pairs of triangles that meet, per step
constexpr size_t kClustersAnObject = 16;       // clusters per object from triangles
constexpr double kClusterShare = 0.25;         // radius of a cluster from triangles, of the tool's
constexpr double kClusterVoxels = 5;           // radius of a cluster from points, in voxels
constexpr uint32_t kAnyNumber = 0xffffffff;    // unlimited budget

void detect_exact(const BodyModel& model, std::span<const MeshShape> objects, BodyState& state,
                  const VoxelQuestion& question, ContactSet& set) {
  HAPTIC_ASSERT(objects.size() <= kMaxObjects);
  for (uint32_t object = 0; object < objects.size(); ++object) {
    const Pose& X_WO = question.X_WO[object];
    std::array<PushCluster, kClustersAnObject> clusters;
    // the rest of the room is shared by the remaining objects
    const size_t left = (kMaxContacts - set.n_contacts) / (objects.size() - object);
    const size_t room = std::min(clusters.size(), left);
    const Pose X_OT = inverse(X_WO) * question.X_WT;
    const ExactAnswer answer =
        exact_contacts(objects[object], model.tool, X_OT, model.exact, state.clusters[object],
                       {state.pairs, state.pushes}, {clusters.data(), room});
    if (answer.left_out > 0 || answer.n_clusters == room) set.flags |= kContactTruncated;
    for (size_t i = 0; i < answer.n_clusters; ++i) {
      HAPTIC_ASSERT(set.n_contacts < kMaxContacts);
      Contact& c = set.contacts[set.n_contacts++];
      c = contact_of(clusters[i], object, X_WO, question.X_WT);
      const PlanePatch reach = contact_reach(objects[object], model.tool, X_OT, c.object_point_O,
                                             clusters[i].point_O, c.normal_O, model.body.radius);
      c.extent = reach.extent;
      c.curvature = reach.curvature;
    }
  }
  set.n_active = set.n_contacts;
}

/// Contacts from which on they share what so many have.
double sharing_of(const ProxyConfig& proxy) {
  constexpr double kCornersOfABox = 4;
  return proxy.sharing == Sharing::kNone ? std::numeric_limits<double>::infinity() : kCornersOfABox;
}

}  // namespace

VoxelModel voxel_model(const VoxelConfig& config, const Pointshell& shell) {
  HAPTIC_ASSERT(config.size > 0);
  VoxelModel model;
  model.shell = shell;
  model.reading = config.field != 0 ? VoxelForce::kField : VoxelForce::kTangentPlanes;
  model.force.stiffness = config.stiffness;
  // the same offset as in the baked map
  model.force.offset = config.offset_layers * config.size;
  model.clusters.radius = kClusterVoxels * config.size;
  model.budget = config.budget == 0 ? kAnyNumber : config.budget;
  model.damping = config.braking;
  model.braking = config.braking_along;
  model.trust_radius = config.size;
  return model;
}

PieceModel piece_model(const SessionConfig& config, const BodyShapes& shapes,
                       const ToolBody& body) {
  PieceModel model;
  model.tool = shapes.tool_pieces;
  model.objects = shapes.pieces;
  model.refine.threshold = config.pieces.threshold;
  model.refine.carry = config.pieces.carry;
  model.refine.bandwidth = config.pieces.bandwidth;
  model.refine.budget = config.pieces.budget == 0 ? kAnyNumber : config.pieces.budget;
  model.stiffness = config.proxy.contact_stiffness;
  model.sharing = sharing_of(config.proxy);
  const double radius = config.pieces.cluster_radius;
  model.clusters.radius = radius > 0 ? radius : kClusterShare * body.radius;
  // pieces that a cluster swallows anyhow touch at one place
  model.refine.spread = 0.5 * model.clusters.radius;
  model.search = body.radius;
  for (const PieceTree& object : model.objects) {
    const uint64_t all = uint64_t{object.pieces.size()} * model.tool.pieces.size();
    model.most_pairs.push_back(static_cast<uint32_t>(std::min<uint64_t>(all, kMostPiecePairs)));
  }
  return model;
}

BodyModel build_body_model(const SessionConfig& config, const BodyShapes& shapes,
                           std::span<const MeshShape> objects) {
  BodyModel model;
  HAPTIC_ASSERT(shapes.volumes.empty() || shapes.volumes.size() == objects.size());
  if (shapes.tool.mesh.triangles.empty()) return model;
  model.tool = shapes.tool;
  model.body = tool_body(shapes.tool.mesh, config.tool);
  model.exact.stiffness = config.proxy.contact_stiffness;
  model.exact.sharing = sharing_of(config.proxy);
  model.exact.clusters.radius = kClusterShare * model.body.radius;
  if (!shapes.pieces.empty()) model.pieces = piece_model(config, shapes, model.body);
  if (shapes.volumes.empty()) return model;
  model.volumes = shapes.volumes;
  model.voxel = voxel_model(config.voxel, shapes.shell);
  model.voxel.objects = model.volumes;
  // the proxy may move half a band without any clearance
  model.clearance = {model.tool, model.body, 0.5 * config.voxel.band, {}};
  for (size_t i = 0; i < model.volumes.size(); ++i) {
    const double layer = push_layer(model.voxel, model.volumes[i], !objects[i].mesh.closed);
    model.clearance.objects.push_back({objects[i], layer});
  }
  return model;
}

BodyState::BodyState(const BodyModel& model) {
  if (!model.has_tool()) return;
  pairs.resize(kMostPairs);
  pushes.resize(kPushesPerPair * kMostPairs);
  if (model.has_maps()) voxel.emplace(model.voxel);
  clearance.resize(model.clearance.objects.size());
  clusters.resize(kMaxObjects);
}

bool detect_bodies(const BodyModel& model, std::span<const MeshShape> objects, Renderer renderer,
                   BodyState& state, const VoxelQuestion& question, const Pose& X_WH,
                   ContactSet& set) {
  const bool is_voxel = row_of(renderer).has_maps;
  if (state.pairs.empty() || (is_voxel && !state.voxel)) return false;
  HAPTIC_ASSERT(model.has_tool() && set.n_contacts == 0);
  set.tool = model.body;
  set.X_WG = question.X_WT;
  if (is_voxel) {
    detect_voxel(model.voxel, *state.voxel, question, set);
    // points not looked up might be inside
    const bool is_known = (set.flags & kContactIterationLimit) == 0;
    if (!state.voxel->is_outside || !is_known) return true;
    const ClearPose clear =
        clear_pose(model.clearance, state.clearance, question.X_WO, question.X_WT, X_WH);
    set.X_WG = clear.X_WT;
    set.clearance = clear.clearance;
  } else {
    detect_exact(model, objects, state, question, set);
  }
  return true;
}

}  // namespace haptic
