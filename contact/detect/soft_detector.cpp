// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "contact/detect/detector.h"
#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"

namespace haptic {

/// The detectors of tools with six degrees of freedom that may enter objects: direct6 and voxel.
/// The proxy is the servo's: the contacts are those of the tool where it has that.
void detect_soft(const ContactModel& model, DetectorState& state, const ContactQuestion& question,
                 ContactSet& set) {
  BodyState& bodies = state.keep<BodyState>(model.bodies);
  if (!question.usable) return;
  if (question.changed) set.flags |= kContactReseeded;
  const ServoFrame& servo = question.servo;
  VoxelQuestion at_proxy;
  at_proxy.X_WT = servo.X_WP;
  at_proxy.V_WT = servo.V_WP;
  at_proxy.X_WO = question.now.X_WO;
  at_proxy.reach = question.reach;
  HAPTIC_ASSERT(model.n_objects <= kMaxObjects);
  const SceneFrame* scene = question.scene;
  for (uint32_t i = 0; scene != nullptr && i < std::min(model.n_objects, scene->n_objects); ++i) {
    at_proxy.V_WO[i] = object_twist_at(*scene, i, servo.t_ns, push_of(servo));
  }
  set.X_WT = servo.X_WP;
  set.X_WG = servo.X_WP;
  set.free_fraction = 1;
  if (!detect_bodies(model.bodies, question.now.shapes, question.renderer, bodies, at_proxy,
                     servo.X_WT, set)) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
  }
}

}  // namespace haptic
