// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "contact/detect/detector.h"
#include "proto/math/assert.h"

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
  at_proxy.V_WO = twists_at(model, question.scene, servo);
  set.X_WT = servo.X_WP;
  set.X_WG = servo.X_WP;
  set.free_fraction = 1;
  if (!detect_bodies(model.bodies, question.now.shapes, question.renderer, bodies, at_proxy,
                     servo.X_WT, set)) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
  }
}

}  // namespace haptic
