// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/step.h"

#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "servo/admittance_step.h"
#include "servo/pace.h"
#include "servo/tick.h"

namespace haptic {
namespace {

/// The velocity of the touched surface, seen at the handle in B. A handle that feels torque is
/// carried as a body by an object that turns; one that feels none, by the tool's origin.
Twist surface_in_device(const ServoModel& model, const Rendered& rendered, const Pose& X_WT) {
  HAPTIC_ASSERT(model.map.motion_scale > 0);
  const Quat q_BW = conjugate(model.map.X_WB.q);
  Twist V_W{rendered.surface_W, {}};
  if (model.limits.max_torque > 0) {
    V_W.w = rendered.surface_turning_W;
    V_W.v = velocity_at(V_W, (X_WT * inverse(model.map.X_HT)).p - X_WT.p);
  }
  return {rotate(q_BW, V_W.v) / model.map.motion_scale, rotate(q_BW, V_W.w)};
}

/// The tool where the device is. False when the device sample cannot be used: the tool then keeps
/// its last good pose.
bool place_tool(const ServoModel& model, ServoState& state, const ServoInput& input,
                ServoFrame& frame) {
  const bool sound = note_sample(input, frame);
  // a finite but absurd sample may overflow on its way into the scene
  const Pose X_WT = tool_pose(model.map, state.clutch, frame.device.X_BH);
  const Twist V_WT = tool_twist(model.map, frame.device.X_BH, frame.device.V_BH);
  if (!sound || !is_finite(X_WT) || !is_finite(V_WT)) {
    frame.X_WT = state.X_WT;
    frame.device.X_BH = {};
    frame.device.V_BH = {};
    return false;
  }
  frame.X_WT =
      apply_clutch(model.map, state.clutch, input.device, state.started ? state.X_WT : X_WT);
  frame.V_WT = V_WT;
  if (state.clutch.held) {
    frame.V_WT = {};
    frame.flags |= kServoClutched;
  }
  return true;
}

/// What the device is told to hold.
void hold_wrench(ServoState& state, const Rendered& rendered, const SafetyOutput& safe,
                 ServoFrame& frame) {
  note_safety(state, rendered, safe, frame);
  frame.F_device_B = safe.F_B;
  frame.X_command_B = frame.device.X_BH;
  // contact must not lead the verified proxy to where the hand cannot be, round an object perhaps
  if (state.safety.jumped) {
    frame.X_WT = state.X_WT;
    frame.V_WT = {};
  }
}

ServoFrame impedance_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  ServoFrame frame{};
  const bool usable = place_tool(model, state, input, frame);
  follow_control(model, state, input);
  continue_pushes(model, state.pushes, input.t_ns);

  // contacts where the objects are now, as far as their age allows
  const ContactWeight age = weigh(state, input, model.dt, frame);
  TickScene scene = scene_of(state, input);
  scene.weight = age.weight;
  const Rendered rendered = render(model, state, input, scene, state.coupling, frame);

  SafetyInput safety = note_inputs(model, state, input, frame);
  safety.F_B = device_wrench(model.map, frame.device.X_BH, frame.F_coupling_W);
  safety.stiffness = handle_stiffness(model.map, state.coupling);
  safety.device_finite = usable;
  safety.contacts_finite = rendered.finite;
  safety.letting_go = state.letting_go;
  safety.fading = (age.flags & (kServoFading | kServoStale)) != 0;
  const Twist surface_B = surface_in_device(model, rendered, frame.X_WT);
  safety.surface_velocity_B = surface_B.v;
  safety.surface_turning_B = surface_B.w;
  const SafetyOutput safe = make_safe(model.limits, state.safety, safety, model.dt);
  hold_wrench(state, rendered, safe, frame);
  note_pushes(model, state.pushes, input, scene, rendered, safe.felt);
  note_frame(state, input, rendered, usable, frame);
  return frame;
}

}  // namespace

ServoFrame servo_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  HAPTIC_ASSERT(model.dt > 0 && model.dead_man_button < 32);
  ServoFrame frame =
      model.admittance ? admittance_step(model, state, input) : impedance_step(model, state, input);
  frame.flags |= keep_pace(state.pace, input, frame.flags, model.sim_period);
  return frame;
}

}  // namespace haptic
