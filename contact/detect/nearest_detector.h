// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/contact_model.h"
#include "proto/wire/renderer.h"

namespace haptic {

/// The detector of the penalty method: the nearest surfaces of where the tool is now. It keeps no
/// proxy: the free place next to the tool stands for it.
struct NearestDetector {
  static constexpr Detector kId = Detector::kNearestSurface;
  explicit NearestDetector(const ContactModel&) {}

  Vec3 free_W;
};

/// Reports the nearest surface of each object.
void detect(const ContactModel& model, NearestDetector& state, const ContactQuestion& question,
            ContactSet& set);

}  // namespace haptic
