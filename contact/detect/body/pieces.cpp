// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/pieces.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "contact/detect/body/cluster_contact.h"
#include "contact/query/triangle/plane_extent.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kClustersOfPieces = 16;  // of an object
// pairs of boxes that are tested in the time of a pair of pieces: 130 ns and about 300 ns
constexpr size_t kBoxesATest = 2;
constexpr size_t kMostMeeting = 1 << 14;  // pairs of triangles that meet, with one object

/// The speed at which surfaces of tool and object slide, at most [m/s].
double sliding_speed(const PieceModel& model, const BodyQuestion& question, uint32_t object) {
  const Twist& V_WO = question.V_WO[object];
  const Vec3 arm_W = question.X_WT.p - question.X_WO[object].p;
  const Vec3 v_W = question.V_WT.v - velocity_at(V_WO, arm_W);
  return norm(v_W) + model.tool_radius * norm(question.V_WT.w - V_WO.w);
}

/// Sorts by place, and lets the pairs of triangles that meet at one place along one normal share
/// it.
void share_places(std::span<TriangleMeeting> meetings) {
  const auto place = [](const TriangleMeeting& m) {
    return std::tie(m.point_A.x, m.point_A.y, m.point_A.z);
  };
  std::sort(meetings.begin(), meetings.end(),
            [&](const auto& m, const auto& other) { return place(m) < place(other); });
  for (auto first = meetings.begin(); first != meetings.end();) {
    const auto end = std::find_if(first + 1, meetings.end(), [&](const TriangleMeeting& m) {
      return !(m.point_A == first->point_A);
    });
    while (first != end) {
      const Vec3 normal = first->normal_A;
      const auto others = std::partition(first + 1, end, [&](const TriangleMeeting& m) {
        return dot(m.normal_A, normal) > kOnePlane;
      });
      const double share = 1 / static_cast<double>(others - first);
      for (; first != others; ++first) first->share = share;
    }
  }
}

/// Where triangles of one object and of the tool meet; null: to know that takes more pairs of boxes
/// or of triangles than the budget allows, or than there is room for.
std::optional<std::span<const TriangleMeeting>> meetings_with(const PieceModel& model,
                                                              const BodyMeshes& meshes,
                                                              uint32_t object, const Pose& X_OT,
                                                              uint32_t budget, PieceState& state) {
  const MeshShape& shape = meshes.objects[object];
  const std::optional<size_t> n_pairs =
      triangle_pairs_within(shape, meshes.tool, X_OT, state.pairs, kBoxesATest * budget);
  if (!n_pairs || *n_pairs > std::min<size_t>(state.pairs.size(), budget)) return {};
  size_t n = 0;
  for (const TrianglePair& pair : std::span(state.pairs).first(*n_pairs)) {
    const PairPushes found = pushes_of_pair(shape.mesh, meshes.tool.mesh, X_OT, pair, 1);
    for (size_t i = 0; i < found.n; ++i) {
      const PointPush& push = found.pushes[i];
      state.meetings[n++] = {model.objects[object].leaf_of[pair.a], model.tool.leaf_of[pair.b],
                             push.point_O, push.normal_O, push.depth};
    }
  }
  share_places({state.meetings.data(), n});
  return std::span<const TriangleMeeting>{state.meetings.data(), n};
}

/// The places of one object that touch or approach, in its frame.
std::span<PointPush> pushes_on(const PieceModel& model, const RefineOptions& refine,
                               const BodyMeshes& meshes, PieceState& state,
                               const BodyQuestion& question, uint32_t object, ContactSet& set) {
  PieceFront& front = state.fronts[object];
  RefineOptions options = refine;
  options.tolerance = question.reach;
  options.speed = sliding_speed(model, question, object);
  // the rest of the budget is shared by the remaining objects
  const uint64_t left = refine.budget - std::min<uint64_t>(state.tested, refine.budget);
  options.budget = static_cast<uint32_t>(left / (state.fronts.size() - object));
  const Pose X_OT = question.X_OT(object);
  front.update(X_OT, options);
  state.tested += front.work();
  std::optional<std::span<const TriangleMeeting>> meetings{std::in_place};
  if (front.overlaps()) {
    meetings = meetings_with(model, meshes, object, X_OT, options.budget, state);
    if (!meetings) set.flags |= kContactIterationLimit;
  }
  const std::span<const PieceContact> contacts = front.contacts(meetings);
  if (front.is_truncated()) set.flags |= kContactIterationLimit;
  HAPTIC_ASSERT(contacts.size() <= state.pushes.size());
  const std::span<PointPush> pushes{state.pushes.data(), contacts.size()};
  for (size_t i = 0; i < pushes.size(); ++i) {
    pushes[i] = {contacts[i].point_b_A, contacts[i].normal_A, contacts[i].depth, model.stiffness};
  }
  share_stiffness(pushes, model.stiffness, model.sharing);
  return pushes;
}

}  // namespace

PieceState::PieceState(const PieceModel& model)
    : pairs(kMostMeeting), meetings(kPushesPerPair * kMostMeeting), clusters(model.objects.size()) {
  HAPTIC_ASSERT(model.most_pairs.size() == model.objects.size());
  fronts.reserve(model.objects.size());
  for (size_t i = 0; i < model.objects.size(); ++i) {
    fronts.emplace_back(model.objects[i], model.tool, std::max(model.most_pairs[i], 1u));
    pushes.resize(std::max(pushes.size(), fronts.back().most_contacts()));
  }
}

void detect_pieces(const PieceModel& model, const RefineOptions& refine, const BodyMeshes& meshes,
                   PieceState& state, const BodyQuestion& question, ContactSet& set) {
  HAPTIC_ASSERT(meshes.objects.size() == state.fronts.size() && question.reach >= 0);
  set.contacts.clear();
  set.n_active = 0;
  state.tested = 0;
  ClusterOptions options = model.clusters;
  options.tolerance = question.reach;
  const auto clusters_of = [&](uint32_t object, std::span<PushCluster> room) {
    const auto pushes = pushes_on(model, refine, meshes, state, question, object, set);
    return cluster_pushes(pushes, options, state.clusters[object], room);
  };
  add_clusters(question, meshes.objects.size(), kClustersOfPieces, set, clusters_of,
               MeshReach{meshes, question, model.search, kMinExtent});
}

}  // namespace haptic
