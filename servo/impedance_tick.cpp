// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/impedance_tick.h"

#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "servo/touch.h"

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

}  // namespace

Outcome impedance_tick(const ServoModel& model, ServoState& state, const ServoInput& input,
                       const TickStart& start) {
  const Pose& X_BH = start.sample.device.X_BH;
  Outcome out;
  // where the sample cannot be used the tool keeps its last good pose
  out.tool = start.sample.usable ? tool_at(model, state, start.sample.device, state.X_WT)
                                 : Tool{state.X_WT, {}};
  out.X_WG = out.tool.X_WT;
  if (start.sample.usable) note_work(model, X_BH, state.clients);
  // contacts where the objects are now, as far as their age allows
  out.touch = touch_of(model, state, input, out.tool, state.coupling, start.age.weight);

  const Rendered& rendered = out.touch.rendered;
  SafetyInput safety = start.safety;
  safety.F_B = device_wrench(model.map, X_BH, rendered.F_W + out.touch.clients.wrenches_W);
  safety.force_closed |= out.tool.is_clutched;
  safety.contacts_finite = rendered.finite;
  safety.fading = (start.age.flags & (kServoFading | kServoStale)) != 0;
  safety.surface_B = surface_in_device(model, rendered, out.tool.X_WT);
  const MotorHeat heat = state.safety.heat;
  out.safe = make_safe(model.limits, state.safety, safety, model.dt);
  const WeightOutput held = hold_weight(model.limits, state.weight,
                                        {input.holding_B, out.safe.F_B, start.sample.device,
                                         start.flags | out.safe.flags, input.released, heat},
                                        model.dt);
  state.safety.heat = held.heat;
  out.F_device_B = held.F_B;
  out.flags = held.flags;
  out.X_command_B = X_BH;
  // contact must not lead the verified proxy to where the hand cannot be, round an object perhaps
  if (out.safe.jumped) out.tool = {state.X_WT, {}, out.tool.is_clutched};
  return out;
}

}  // namespace haptic
