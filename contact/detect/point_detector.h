// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/contact_model.h"
#include "contact/detect/point/near_features.h"

namespace haptic {

/// The detector of the hard renderers of a point. Moves the verified proxy towards the tool, less
/// what friction holds back. The answer is used later (`prediction`), so the facets reported are
/// those that carry a proxy sent on to where the tool will then be (tool and objects on their way
/// as they move now), then the features it may reach before the next two answers. A slide that was
/// cut short is held where it ended, by one plane across the way to the tool. A restarted contact
/// takes the proxy up where the servo last saw it.
struct PointDetector {
  explicit PointDetector(const ContactModel&) {}
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

  PointProxy proxy;  // verified: never inside
  NearScratch scratch;
  std::array<NearFeature, kMaxContacts> features;
};

}  // namespace haptic
