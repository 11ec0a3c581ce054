// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>

#include "contact/detect/detector.h"
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

/// Without a tool where the session has a point.
struct LedTool {
  explicit LedTool(const ContactModel& model) {
    if (model.bodies.has_tool()) tool.emplace(rigid_model(model));
  }
  std::optional<RigidTool> tool;
};

}  // namespace

/// The detector of tools with six degrees of freedom that never enter an object: it leads the
/// verified pose of the tool and reports its contacts (rigid_tool.h).
void detect_rigid(const ContactModel& model, DetectorState& state, const ContactQuestion& question,
                  ContactSet& set) {
  std::optional<RigidTool>& tool = state.keep<LedTool>(model).tool;
  if (question.changed && tool) tool->lose();
  if (!question.usable) return;
  if (question.changed) set.flags |= kContactReseeded;
  set.X_WG = question.servo.X_WP;
  if (!tool) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return;
  }
  tool->answer(rigid_model(model), question.servo, {question.now.X_WO.data(), model.n_objects},
               question.reach, set);
}

}  // namespace haptic
