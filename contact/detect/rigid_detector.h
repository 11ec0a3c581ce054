// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "contact/detect/contact_model.h"
#include "proto/wire/renderer.h"

namespace haptic {

/// The detector of tools with six degrees of freedom that never enter an object.
struct RigidDetector {
  static constexpr Detector kId = Detector::kRigidTool;
  explicit RigidDetector(const ContactModel& model);

  std::optional<RigidTool> tool;  // none: the session has a point
};

/// Leads the verified pose of the tool and reports its contacts (rigid_tool.h).
void detect(const ContactModel& model, RigidDetector& state, const ContactQuestion& question,
            ContactSet& set);

}  // namespace haptic
