// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/detector.h"
#include "contact/given/given_touch.h"
#include "contact/grasp.h"
#include "proto/config/config.h"
#include "proto/wire/behind.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A tick of the servo, and how many it had skipped by then.
struct AnsweredTick {
  uint64_t tick = 0, skipped = 0;
};

/// All that survives a step.
struct ContactState {
  ContactState() = default;
  /// With the detector of the session's renderer.
  explicit ContactState(const ContactModel& model);

  AnyDetector detector;  // of the last question's renderer
  Renderer renderer{};
  Grasp grasp;
  GivenTouchState given;  // by clients
  uint64_t seq = 0;
  uint64_t reseeds = 0;
  int64_t last_answered_ns = 0;
  double period = 1e-3;  // smoothed time between answered frames [s]
  AnsweredTick last;     // that was answered
  uint64_t skipped = 0;  // frames without an answer, since the first
  BehindSince behind;
};

/// Answers one ServoFrame, as far as what is grasped draws the tool (grasp.h), with the detector of
/// its renderer, which looks ahead to what the tool may reach before the next two answers, within
/// v·(2·T_contact + T). `scene` may be null. Another detector than before begins knowing nothing.
/// Allocates nothing, but for another detector, and for what a rigid tool remembers of the surfaces
/// near it, which grows until it has held the most.
ContactSet contact_step(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                        const SceneFrame* scene);

}  // namespace haptic
