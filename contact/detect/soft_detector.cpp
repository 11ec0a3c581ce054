// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/soft_detector.h"

#include <limits>

#include "contact/detect/body/cluster_contact.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kMostPairs = 1 << 14;  // pairs of triangles that meet, per step
constexpr size_t kMostOfAnObject = 16;  // clusters from triangles

/// The question at the servo's proxy, and what the set says of that. None where it is not usable,
/// or where the session has nothing that answers it.
std::optional<BodyQuestion> at_proxy(const ContactModel& model, const ContactQuestion& question,
                                     bool is_answered, ContactSet& set) {
  if (!question.usable) return {};
  if (question.changed) set.flags |= kContactReseeded;
  const ServoFrame& servo = question.servo;
  set.X_WT = set.X_WG = servo.X_WP;
  if (!is_answered) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return {};
  }
  HAPTIC_ASSERT(model.has_tool() && set.contacts.empty());
  set.tool = model.body;
  return BodyQuestion{servo.X_WP, servo.V_WP, question.now.X_WO,
                      twists_at(model, question.scene, servo), question.reach};
}

}  // namespace

ExactDetector::ExactDetector(const ContactModel& model) {
  if (!model.has_tool()) return;
  pairs_.resize(kMostPairs);
  pushes_.resize(kPushesPerPair * kMostPairs);
  clusters_.resize(model.shapes.size());
}

void ExactDetector::detect(const ContactModel& model, const ContactQuestion& question,
                           ContactSet& set) {
  const auto at = at_proxy(model, question, model.has_tool(), set);
  if (!at) return;
  const BodyMeshes meshes{question.now.shapes, model.tool};
  const auto clusters_of = [&](uint32_t object, std::span<PushCluster> room) {
    const ExactAnswer answer =
        exact_contacts(meshes.objects[object], meshes.tool, at->X_OT(object), model.exact,
                       clusters_[object], {pairs_, pushes_}, room);
    if (answer.left_out > 0) set.flags |= kContactTruncated;
    return answer.n_clusters;
  };
  add_clusters(*at, meshes.objects.size(), kMostOfAnObject, set, clusters_of,
               MeshReach{meshes, *at, model.body.radius});
  // one that just touches counts, too
  set.n_active = static_cast<uint32_t>(set.contacts.size());
}

VoxelDetector::VoxelDetector(const ContactModel& model)
    : clearance_(model.clearance.objects.size()) {
  if (model.has_maps()) voxel_.emplace(model.voxel);
}

void VoxelDetector::detect(const ContactModel& model, const ContactQuestion& question,
                           ContactSet& set) {
  const auto at = at_proxy(model, question, voxel_.has_value(), set);
  if (!at) return;
  detect_voxel(model.voxel, *voxel_, *at, set);
  // points not looked up might be inside
  if (!voxel_->is_outside || (set.flags & kContactIterationLimit) != 0) return;
  const ClearPose clear =
      clear_pose(model.clearance, clearance_, {at->X_WO.data(), at->X_WO.size()}, at->X_WT,
                 question.servo.X_WT);
  set.X_WG = clear.X_WT;
  for (size_t i = 0; i < clear.clearance.size(); ++i) set.objects[i].clearance = clear.clearance[i];
}

void PieceDetector::detect_by(const RefineOptions& refine, const ContactModel& model,
                              const ContactQuestion& question, ContactSet& set) {
  const auto at = at_proxy(model, question, !model.pieces.objects.empty(), set);
  if (at) detect_pieces(model.pieces, refine, {question.now.shapes, model.tool}, state_, *at, set);
}

void LocalizedDetector::detect(const ContactModel& model, const ContactQuestion& question,
                               ContactSet& set) {
  RefineOptions refine = model.pieces.refine;
  refine.threshold = refine.carry = refine.bandwidth = 0;
  refine.budget = std::numeric_limits<uint32_t>::max();
  detect_by(refine, model, question, set);
}

void SensationDetector::detect(const ContactModel& model, const ContactQuestion& question,
                               ContactSet& set) {
  detect_by(model.pieces.refine, model, question, set);
}

}  // namespace haptic
