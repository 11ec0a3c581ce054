// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/rigid_detector.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

RigidToolModel rigid_model(const ContactModel& model) {
  HAPTIC_ASSERT(model.n_objects <= kMaxObjects);
  return {{model.shapes.data(), model.n_objects},
          model.bodies.tool,
          model.bodies.body,
          model.rigid,
          model.crease_cosine,
          model.has_friction};
}

}  // namespace

RigidDetector::RigidDetector(const ContactModel& model) {
  if (model.bodies.has_tool()) tool.emplace(rigid_model(model));
}

void detect(const ContactModel& model, RigidDetector& state, const ContactQuestion& question,
            ContactSet& set) {
  if (question.changed && state.tool) state.tool->lose();
  if (!question.usable) return;
  if (question.changed) set.flags |= kContactReseeded;
  set.X_WG = question.servo.X_WP;
  if (!state.tool) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return;
  }
  state.tool->answer(rigid_model(model), question.servo,
                     {question.now.X_WO.data(), model.n_objects}, question.reach, set);
}

}  // namespace haptic
