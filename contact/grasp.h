// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/contact_model.h"

namespace haptic {

/// What the tool holds while a button is down.
struct Grasp {
  bool was_pressed = true;        // one that is down when contact starts seizes nothing
  uint32_t object = kMaxObjects;  // what is held; kMaxObjects: nothing
  Pose X_OT;                      // of the proxy that has seized it
  int64_t since_ns = 0;           // ServoFrame::t_ns then

  bool holds() const { return object < kMaxObjects; }
};

/// Lets go where the button is up, or no force may be felt. True: the button has just gone down.
bool follow_button(Grasp& grasp, int32_t button, const ServoFrame& servo);

/// The frame as a detector is asked about it while an object is held: its tool is drawn towards
/// where it is held, so that the proxy stays there, and other objects are seen from there.
ServoFrame drawn_frame(const Grasp& grasp, uint32_t hand, const ServoFrame& servo,
                       const SceneFrame* scene, const PointScene& now);

/// Seizes the object that is nearest to the proxy of an answer, where one touches it or is nearer
/// than kMinReach (proto/wire/look_ahead.h).
void seize(Grasp& grasp, const ContactModel& model, const ServoFrame& servo, const ContactSet& set);

/// Adds the guide rows of what is held. A tool that is a body has six: along the three axes of the
/// tool at its centre of mass, and, a radius away along each axis, one along the next. Their
/// differences are turns times the radius, so that the rows are as well conditioned as the tool is
/// large. A point has the first three, along the axes of the object at the proxy. The other
/// contacts of the held object stay in the set, for the tick in which the button is up again.
void report_grasp(Grasp& grasp, const ContactModel& model, ContactSet& set);

}  // namespace haptic
