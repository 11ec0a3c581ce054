// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/any_detector.h"  // made of the renderers' lines: renderer_types.cmake

namespace haptic {

/// Answers a question by the detector of its renderer, a class of any *_detector.h of this folder
/// that the line in proto/wire/renderers.def names: made of a ContactModel, with
///   void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set)
/// which fills in the contacts of a set whose header is there: contacts, n_active and
/// the place X_WG. Where the question is not usable: no contacts, and the place that is known. What
/// is kept is the detector of the last question. Another one takes its place and knows nothing;
/// only then is anything allocated.
void detect(const ContactModel& model, AnyDetector& kept, const ContactQuestion& question,
            ContactSet& set);

}  // namespace haptic
