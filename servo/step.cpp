// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/step.h"

#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "servo/admittance_tick.h"
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

/// The tool where the device is; where the sample cannot be used it keeps its last good pose.
Tool place_tool(const ServoModel& model, ServoState& state, const Sample& sample) {
  if (!sample.usable) return {state.X_WT, {}};
  const DeviceState& device = sample.device;
  const Pose X_WT = state.started ? state.X_WT : tool_pose(model.map, state.clutch, device.X_BH);
  Tool tool{apply_clutch(model.map, state.clutch, device, X_WT), {}, state.clutch.held};
  if (!tool.is_clutched) tool.V_WT = tool_twist(model.map, device.X_BH, device.V_BH);
  return tool;
}

/// A device that measures a pose and is told a wrench: tool, proxy, wrench, safety.
Outcome impedance_tick(const ServoModel& model, ServoState& state, const ServoInput& input,
                       const Sample& sample, const ContactWeight& age) {
  Outcome out;
  out.sample = sample;
  out.tool = place_tool(model, state, sample);
  out.X_WG = out.tool.X_WT;
  // contacts where the objects are now, as far as their age allows
  out.touch = touch_of(model, state, input, out.tool, state.coupling, age.weight);

  const Rendered& rendered = out.touch.rendered;
  SafetyInput safety = safety_input(model, state, input, sample, out.tool.is_clutched);
  safety.F_B = device_wrench(model.map, sample.device.X_BH, rendered.F_W);
  safety.contacts_finite = rendered.finite;
  safety.fading = (age.flags & (kServoFading | kServoStale)) != 0;
  safety.surface_B = surface_in_device(model, rendered, out.tool.X_WT);
  out.safe = make_safe(model.limits, state.safety, safety, model.dt);
  out.felt = out.safe.felt;
  out.F_device_B = out.safe.F_B;
  out.X_command_B = sample.device.X_BH;
  // contact must not lead the verified proxy to where the hand cannot be, round an object perhaps
  if (out.safe.jumped) out.tool = {state.X_WT, {}, out.tool.is_clutched};
  return out;
}

}  // namespace

ServoFrame servo_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  HAPTIC_ASSERT(model.dt > 0 && model.dead_man_button < 32);
  const Sample sample = sample_of(model, state.clutch, input);
  follow_control(model, state, input);
  continue_pushes(model, state.pushes, input.t_ns);
  const ContactWeight age = weigh(state, input, model.dt);
  const Outcome outcome = model.admittance ? admittance_tick(model, state, input, sample, age)
                                           : impedance_tick(model, state, input, sample, age);
  ServoFrame frame = settle(model, state, input, age, outcome);
  frame.flags |= keep_pace(state.pace, input, frame.flags, model.sim_period);
  return frame;
}

}  // namespace haptic
