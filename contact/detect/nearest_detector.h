// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/contact_model.h"

namespace haptic {

/// The detector of the penalty method: the nearest surface of each object, seen from where the tool
/// is now. It keeps no proxy: the free place next to the tool stands for it.
class NearestDetector {
 public:
  explicit NearestDetector(const ContactModel&) {}
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

 private:
  Vec3 free_W_;
};

}  // namespace haptic
