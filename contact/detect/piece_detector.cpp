// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>

#include "contact/detect/body/pieces.h"
#include "contact/detect/detector.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// The contacts of the tool where the servo has its proxy, by convex pieces.
void detect_by_pieces(const ContactModel& model, const RefineOptions& refine, DetectorState& state,
                      const ContactQuestion& question, ContactSet& set) {
  const PieceModel& pieces = model.bodies.pieces;
  PieceState& kept = state.keep<PieceState>(pieces);
  if (!question.usable) return;
  if (question.changed) {
    set.flags |= kContactReseeded;
    kept.forget();
  }
  const ServoFrame& servo = question.servo;
  set.X_WT = set.X_WG = servo.X_WP;
  set.free_fraction = 1;
  if (pieces.objects.empty()) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return;
  }
  set.tool = model.bodies.body;
  PieceQuestion at_proxy;
  at_proxy.X_WT = servo.X_WP;
  at_proxy.V_WT = servo.V_WP;
  at_proxy.X_WO = question.now.X_WO;
  at_proxy.reach = question.reach;
  at_proxy.tool_radius = norm(model.bodies.body.centre_T) + model.bodies.body.radius;
  at_proxy.V_WO = twists_at(model, question.scene, servo);
  detect_pieces(pieces, refine, {question.now.shapes, model.bodies.tool}, kept, at_proxy, set);
}

}  // namespace

/// Convex pieces at full detail (Kim, Otaduy, Lin, Manocha 2003).
void detect_localized(const ContactModel& model, DetectorState& state,
                      const ContactQuestion& question, ContactSet& set) {
  RefineOptions refine = model.bodies.pieces.refine;
  refine.threshold = refine.carry = refine.bandwidth = 0;
  refine.budget = std::numeric_limits<uint32_t>::max();
  detect_by_pieces(model, refine, state, question, set);
}

/// Contact levels of detail (Otaduy & Lin 2003).
void detect_sensation(const ContactModel& model, DetectorState& state,
                      const ContactQuestion& question, ContactSet& set) {
  detect_by_pieces(model, model.bodies.pieces.refine, state, question, set);
}

}  // namespace haptic
