// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/contact_model.h"
#include "proto/wire/renderer.h"

namespace haptic {

/// The detectors of tools with six degrees of freedom that may enter objects: direct6 and voxel.
/// The proxy is the servo's.
struct SoftDetector {
  static constexpr Detector kId = Detector::kSoftBody;
  explicit SoftDetector(const ContactModel& model) : bodies(model.bodies) {}

  BodyState bodies;
};

/// Reports the contacts of the tool where the servo has its proxy.
void detect(const ContactModel& model, SoftDetector& state, const ContactQuestion& question,
            ContactSet& set);

}  // namespace haptic
