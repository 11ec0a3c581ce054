// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "servo/step.h"

namespace haptic {

/// What a renderer makes of a tick, before safety.
struct Rendered {
  Pose X_WP;                  // the proxy
  std::optional<Twist> V_WP;  // where its solver knows it
  Wrench F_W;                 // of the coupling on the tool, at its origin
  Vec3 surface_W;             // velocity of what carries the proxy
  Vec3 held_back_W;           // how far friction holds the proxy back
  int n_pushing = 0;          // contacts
  bool finite = true;         // the contacts were
  bool converged = true;
  std::array<Wrench, kMaxObjects> object_impulse_W{};  // since start, if this tick is felt
};

/// The state of the solver in use; another's is dropped.
template <class State>
State& keep(ProxyState& proxy) {
  if (!std::holds_alternative<State>(proxy)) proxy.emplace<State>();
  return *std::get_if<State>(&proxy);  // std::get could throw
}

/// The renderers of a point: planes at this tick, the proxy of the solver that goes with the
/// detector of the contacts, the coupling's force. `frame` has the tool.
Rendered render_point(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const TickScene& scene, const ServoFrame& frame);

/// The coupling in force, with the bounds of the session.
VirtualCoupling coupling_in_force(const ServoModel& model, const ServoState& state);

/// The tool that contact has baked, else the session's.
RigidBody tool_in_force(const ServoModel& model, const ContactSet& contacts);

/// Rate-limits the step of the force since the last tick (servo/safety/force_continuity.h). What is
/// added comes from the object that carried the tool then.
void limit_step(const ServoModel& model, ServoState& state, const TickScene& scene,
                const Pose& X_WT, BodySolution& solution);

/// What a solver of a body came to, and the opposite of what the objects pushed it with, which they
/// are pushed with, about their origins.
Rendered rendered_body(const ServoModel& model, const ServoState& state, const TickScene& scene,
                       const BodySolution& solution);

/// The renderers of a tool that may enter objects, with six degrees of freedom: soft contacts at
/// this tick, the proxy of the session's solver, the coupling's wrench. Needs contacts.
Rendered render_body(const ServoModel& model, ServoState& state, const ServoInput& input,
                     const TickScene& scene, const ServoFrame& frame);

/// The renderers of a tool that never enters an object: the contacts' verified pose at this tick,
/// the proxy of the solver that goes with the detector, the coupling's wrench. Needs contacts.
Rendered render_rigid(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const TickScene& scene, const ServoFrame& frame);

}  // namespace haptic
