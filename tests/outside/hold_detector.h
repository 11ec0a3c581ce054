// SPDX-License-Identifier: GPL-3.0-or-later
// Detector of the renderer "hold": the plane of the nearest surface.
#pragma once

#include "contact/detect/contact_model.h"
#include "contact/detect/point/nearest_surface.h"

namespace haptic {

struct HoldDetector {
  explicit HoldDetector(const ContactModel&) {}

  void detect(const ContactModel&, const ContactQuestion& question, ContactSet& set) {
    const Vec3& tool_W = question.servo.X_WT.p;
    std::array<NearestSurface, kMaxObjects> surfaces;
    if (!question.usable || nearest_surfaces(question.now, tool_W, question.reach, surfaces) == 0) {
      return;
    }
    const auto& [facet, at, depth] = surfaces[0];
    set.contacts.push_back(contact_at(question.now, facet, at, 1));
    set.n_active = depth > 0;
  }
};

}  // namespace haptic
