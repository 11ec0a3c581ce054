// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "contact/detect/contact_model.h"

namespace haptic {

/// What finds the contacts for a renderer, and what it keeps between steps.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Fills in the contacts of a set whose header is there: contacts, n_contacts, n_active and the
  /// place X_WG. Where the question is not usable: no contacts, and the place that is known.
  virtual void detect(const ContactModel& model, const ContactQuestion& question,
                      ContactSet& set) = 0;
};

/// A detector that has kept nothing yet; two renderers that name the same function share it.
using MakeDetector = std::unique_ptr<Detector>(const ContactModel& model);

/// The one in the renderer's line of proto/wire/renderers.def.
MakeDetector& detector_of(Renderer renderer);

}  // namespace haptic
