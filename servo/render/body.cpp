// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/body.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// The object that pushes the proxy hardest; kNoObject if none does.
uint32_t carrier_of(const BodySolution& solution) {
  double hardest = 0;
  uint32_t carrier = kNoObject;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    const double push = norm(solution.push_W[i].f);
    if (push > hardest) hardest = push, carrier = i;
  }
  return carrier;
}

}  // namespace

const ToolBody& tool_in_force(const ServoModel& model, const ContactSet& contacts) {
  return contacts.tool.mass > 0 ? contacts.tool : model.tool;
}

BodyTick body_tick(const ServoModel& model, const RenderQuestion& question) {
  HAPTIC_ASSERT(model.dt > 0);
  return {question.scene, {question.X_WT, question.V_WT},          &question.contacts,
          model.dt,       tool_in_force(model, question.contacts), question.coupling};
}

Rendered rendered_body(const RenderQuestion& question, const BodySolution& solution) {
  Rendered out;
  out.X_WP = solution.proxy.X_WT;
  out.V_WP = solution.proxy.V_WT;
  out.F_W = solution.F_hand_W;
  if (const uint32_t carrier = carrier_of(solution); carrier != kNoObject) {
    const Vec3 arm_W = solution.proxy.X_WT.p - question.scene.X_WO[carrier].p;
    out.surface_W = velocity_at(question.scene.V_WO[carrier], arm_W);
    out.surface_turning_W = question.scene.V_WO[carrier].w;
  }
  out.held_back_W = solution.held_back_W;
  out.n_pushing = solution.n_pushing;
  out.finite = solution.finite;
  out.converged = solution.converged;
  out.push_W = solution.push_W;
  return out;
}

Rendered rendered_body(const ServoModel& model, const RenderQuestion& question,
                       BodySolution solution, FeltStep& continuity) {
  // contacts that do not count any more, or not yet, are not held either
  if (!solution.finite || !(question.scene.weight > 0)) {
    continuity = {};
    return rendered_body(question, solution);
  }
  const uint32_t giver = continuity.carrier;
  const Coupling& k = question.coupling;
  const Wrench F_W = limit_felt_step(continuity,
                                     {solution.F_hand_W, question.X_WT, carrier_of(solution),
                                      k.translational_stiffness, k.rotational_stiffness, model.dt},
                                     question.scene.X_WO);
  const Wrench added_W = F_W + -solution.F_hand_W;
  if (giver < kMaxObjects) solution.push_W[giver] = solution.push_W[giver] + added_W;
  solution.F_hand_W = F_W;
  return rendered_body(question, solution);
}

}  // namespace haptic
