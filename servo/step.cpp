// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/step.h"

#include "proto/math/assert.h"
#include "servo/admittance_tick.h"
#include "servo/impedance_tick.h"
#include "servo/pace.h"

namespace haptic {
namespace {

/// Writes the frame of a tick whose values are all known.
ServoFrame frame_of(const ServoModel& model, const ServoState& state, const ServoInput& input,
                    const TickStart& start, const Outcome& outcome, uint32_t flags) {
  ServoFrame frame{};
  frame.tick = input.tick;
  frame.t_ns = input.t_ns;
  frame.realtime_ns = input.realtime_ns;
  frame.wake_late_ns = input.wake_late_ns;
  frame.skipped = input.skipped;
  frame.flags = flags;
  frame.fault = static_cast<uint32_t>(state.safety.fault);
  frame.renderer = static_cast<uint32_t>(state.renderer);

  frame.device = start.sample.device;
  frame.F_device_B = outcome.F_device_B;
  frame.X_command_B = outcome.X_command_B;
  frame.X_WT = outcome.tool.X_WT;
  frame.V_WT = outcome.tool.V_WT;

  frame.X_WG = outcome.X_WG;
  if (input.contacts != nullptr) {
    frame.contact_seq = input.contacts->seq;
    frame.contact_tick = input.contacts->answers_tick;
    frame.X_WG = input.contacts->X_WG;
  }
  if (input.scene != nullptr) frame.scene_seq = input.scene->seq;
  if (input.control != nullptr) frame.control_revision = input.control->revision;

  const Rendered& rendered = outcome.touch.rendered;
  frame.fade = start.age.weight;
  frame.F_coupling_W = rendered.F_W;
  frame.translational_stiffness = outcome.touch.coupling.translational_stiffness;
  frame.rotational_stiffness = outcome.touch.coupling.rotational_stiffness;
  frame.X_WP = rendered.X_WP;
  frame.V_WP = outcome.touch.V_WP;
  frame.depth = outcome.touch.depth;
  frame.n_contacts = static_cast<uint32_t>(rendered.n_pushing);
  // where nothing is felt nothing holds
  if ((flags & kServoClosed) == 0) frame.held_back_W = rendered.held_back_W;

  const size_t n_pushed = input.scene != nullptr ? input.scene->responses.size() : 0;
  frame.pushes.assign(std::span(state.pushes.objects).first(n_pushed));
  if (input.contacts != nullptr) {
    note_felt(model, state.clients, outcome.touch.clients, *input.contacts, frame);
  }
  frame.forgotten_impulse_W = state.pushes.forgotten_W;
  frame.impulses_since_ns = state.pushes.since_ns;
  return frame;
}

/// Keeps what the next tick needs of this one, counts what the objects are pushed with, and writes
/// the frame.
ServoFrame settle(const ServoModel& model, ServoState& state, const ServoInput& input,
                  const TickStart& start, const Outcome& outcome) {
  uint32_t flags = start.flags | outcome.touch.flags | outcome.safe.flags | outcome.flags;
  if (outcome.tool.is_clutched) flags |= kServoClutched;
  if ((flags & kServoClosed) != 0) {
    state.render.forget();
    state.grasp = {};
  }
  const Touch& touch = outcome.touch;
  // the hand feels the torque of a tool about its handle; that of a point, which has none, about
  // the proxy
  const RendererRow* renderer = renderer_of(input.contacts);
  const bool is_body = renderer != nullptr && is_of_body(renderer->id);
  const Pose& X_WP = touch.rendered.X_WP;
  const Vec3 at_W = is_body ? (X_WP * inverse(model.map.X_HT)).p : X_WP.p;
  note_pushes(state.pushes,
              {model.hand, input.scene, touch.scene, touch.rendered, at_W, outcome.safe.felt},
              model.dt);
  keep_felt(model, start.sample.device.X_BH, touch.clients, outcome.safe.felt, state.clients);
  const ServoFrame frame = frame_of(model, state, input, start, outcome, flags);
  state.started = state.started || start.sample.usable;
  state.t_ns = input.t_ns;
  if (start.sample.usable) state.X_WT = frame.X_WT;
  state.X_WP = frame.X_WP;
  return frame;
}

}  // namespace

ServoFrame servo_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  HAPTIC_ASSERT(model.dt > 0 && model.dead_man_button < 32);
  const TickStart start = begin_tick(model, state, input);
  continue_pushes(state.pushes, input.t_ns, !model.admittance, model.dt);
  const Outcome outcome = model.admittance ? admittance_tick(model, state, input, start)
                                           : impedance_tick(model, state, input, start);
  ServoFrame frame = settle(model, state, input, start, outcome);
  frame.flags |= keep_pace(state.pace, input, frame.flags, model.sim_period);
  frame.behind_since_ns = state.behind.seen(input.skipped, input.t_ns);
  return frame;
}

}  // namespace haptic
