// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "contact/detect/body/god_object6.h"
#include "contact/detect/contact_model.h"

namespace haptic {

/// The detector of tools with six degrees of freedom that never enter an object: moves the verified
/// pose of the tool after each ServoFrame, and reports its contacts.
///
/// The target of the god-object is the hand; with friction, and always with constrained dynamics,
/// it is the servo's proxy: then contact sweeps from the last verified pose, and the servo projects
/// back. While the force is off the tool is placed at the hand if it is free there. A start inside
/// an object is moved to the nearest free pose found, which the set reports.
///
/// If the objects have moved on without a free path for the tool, the set shows the objects where
/// the tool is free of them. After 20 such steps the force is zero, and the set says so, until a
/// path is found, on the side of each object where the tool was last; or, half a second later,
/// until the tool is free at the hand, where it restarts without a force.
class RigidDetector {
 public:
  explicit RigidDetector(const ContactModel& model);
  // the god-object views what its fronts keep
  RigidDetector(const RigidDetector&) = delete;
  RigidDetector& operator=(const RigidDetector&) = delete;

  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

 private:
  void place(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void wait(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set);
  void report(const ContactModel& model, const ServoFrame& servo, ContactSet& set);
  void answer(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

  std::optional<GodObject6> god_object_;  // none: the session has a point
  int n_lost_ = 0;                        // consecutive steps
};

}  // namespace haptic
