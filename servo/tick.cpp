// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/tick.h"

#include <algorithm>
#include <cmath>

#include "proto/config/renderer_needs.h"
#include "proto/wire/mapping.h"

namespace haptic {
namespace {

constexpr double kRampTime = 0.200;  // of a change of the coupling [s]

/// Checks where an impedance device or the arm of an admittance device is. A sample that is finite
/// but absurd may overflow on its way into the scene: it is not usable either.
Sample sample_of(const ServoModel& model, const Clutch& clutch, const ServoInput& input) {
  Sample sample{input.device};
  DeviceState& device = sample.device;
  if (!is_finite(device.F_hand_B)) device.F_hand_B = {};
  sample.usable = is_sound(device) && is_finite(tool_pose(model.map, clutch, device.X_BH)) &&
                  is_finite(tool_twist(model.map, device.X_BH, device.V_BH));
  if (!sample.usable) {
    device.X_BH = {};
    device.V_BH = {};
  }
  return sample;
}

Coupling in_force(const CouplingRamp& ramp) {
  const double share = std::min(ramp.time / kRampTime, 1.0);
  Coupling now = ramp.to;
  if (share == 1) return now;
  for (double Coupling::*const k :
       {&Coupling::translational_stiffness, &Coupling::translational_damping,
        &Coupling::rotational_stiffness, &Coupling::rotational_damping}) {
    now.*k = ramp.from.*k + share * (ramp.to.*k - ramp.from.*k);
  }
  return now;
}

/// Another solver of a soft body begins where nothing is felt any more, with nothing of the former:
/// its proxy is anew at the hand.
void follow_soft_solver(ServoState& state, const ServoInput& input) {
  const std::optional<SoftSolver> wanted = soft_solver_of(input.control->solver);
  const bool is_in_use = is_soft_body(input.contacts);
  state.letting_go = wanted != state.soft_solver && is_in_use && state.safety.gain > 0;
  if (wanted == state.soft_solver || state.letting_go) return;
  if (is_in_use) state.render.forget();
  state.soft_solver = wanted;
}

/// Sets coupling, renderer and solver as they are wanted, and the coupling in force.
void follow_control(const ServoModel& model, ServoState& state, const ServoInput& input) {
  if (!state.started) {
    state.coupling = model.coupling;
    state.ramp = {model.coupling, model.coupling, 0};
    state.renderer = model.renderer;
  }
  if (input.control == nullptr) return;
  const uint32_t renderer = input.control->renderer;
  if (is_renderer(renderer)) state.renderer = static_cast<Renderer>(renderer);
  const Coupling wanted{input.control->translational_stiffness,
                        input.control->translational_damping,
                        input.control->rotational_stiffness,
                        input.control->rotational_damping,
                        model.coupling.max_force,
                        model.coupling.max_torque};
  state.coupling = ramp_coupling(state.ramp, wanted, model.dt);
  follow_soft_solver(state, input);
}

/// True if the coupling, as it is felt at the handle, is far stiffer than the device holds.
bool is_forced(const ServoModel& model, const ServoState& state) {
  // a hand that feels contacts directly feels none
  const SoftSolver solver = state.soft_solver.value_or(solver_of(model.proxy, state.renderer));
  if (is_of_body(state.renderer) && !has_springs(solver, state.renderer)) return false;
  const Coupling& coupling = state.coupling;
  const double turning = model.map.force_scale, moving = model.map.motion_scale * turning;
  CoupledAxis along = model.moving, about = model.turning;
  along.stiffness = moving * coupling.translational_stiffness;
  along.coupling_damping = moving * coupling.translational_damping;
  about.stiffness = turning * coupling.rotational_stiffness;
  about.coupling_damping = turning * coupling.rotational_damping;
  return is_far_beyond(along) || is_far_beyond(about);
}

/// With the first ControlFrame: what was asked of a former servo is no request to this one, and a
/// fault that nobody has cleared since goes on.
void begin_safety(ServoState& state, const ControlFrame& control) {
  if (state.controlled) return;
  state.controlled = true;
  state.safety.fault_clears = control.fault_clears;
  if (state.safety.fault == Fault::kNone) state.safety.fault = static_cast<Fault>(control.fault);
}

/// The coupling in force as the handle would feel it.
HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling) {
  const double stiffness = map.force_scale * coupling.translational_stiffness;
  const double lever = norm(map.X_HT.p);
  return {map.motion_scale * stiffness, lever * stiffness,
          map.force_scale * coupling.rotational_stiffness, lever};
}

/// Translates the inputs of this tick for safety. A contact set that placed the proxy anew restarts
/// the force softly.
SafetyInput safety_input(const ServoModel& model, ServoState& state, const ServoInput& input,
                         const Sample& sample, bool same_writer) {
  SafetyInput safety;
  safety.device = sample.device;
  safety.device_finite = sample.usable;
  safety.stiffness = handle_stiffness(model.map, state.coupling);
  safety.letting_go = state.letting_go;
  safety.released = input.released;
  safety.now_ns = std::max(input.t_ns + input.wake_late_ns, input.device.t_ns);
  safety.force_closed = input.contacts == nullptr;
  if (input.contacts != nullptr) {
    const ContactSet& set = *input.contacts;
    // a count, not an event: the set that placed the proxy anew may have been overwritten unread
    safety.restart = set.reseeds > 0 && (!same_writer || set.reseeds != state.reseeds);
    state.reseeds = set.reseeds;
    safety.force_closed = (set.flags & kContactNoFreePose) != 0;
  }
  const int32_t button = model.dead_man_button;
  safety.armed = button < 0 || is_pressed(input.device, button);
  // before the first ControlFrame it is not known that this hand may feel anything
  safety.armed &= input.control != nullptr && input.control->armed != 0;
  if (input.control != nullptr) {
    begin_safety(state, *input.control);
    safety.fault_clears = input.control->fault_clears;
  }
  return safety;
}

}  // namespace

Coupling ramp_coupling(CouplingRamp& ramp, const Coupling& wanted, double dt) {
  HAPTIC_ASSERT(dt > 0 && ramp.time >= 0);
  if (wanted != ramp.to) ramp = {in_force(ramp), wanted, 0};
  ramp.time += dt;
  return in_force(ramp);
}

bool is_sound(const DeviceState& device) {
  constexpr double kUnit = 1e-3;
  // beyond the longest length of a session file a box tree tells no two triangles apart, and one
  // query tests all pairs exactly
  constexpr double kFar = 1e6;  // [m], [m/s], [rad/s]
  return is_finite(device.X_BH) && is_finite(device.V_BH) && norm(device.X_BH.p) < kFar &&
         norm(device.V_BH.v) < kFar && norm(device.V_BH.w) < kFar &&
         std::fabs(dot(device.X_BH.q, device.X_BH.q) - 1) < kUnit;
}

TickStart begin_tick(const ServoModel& model, ServoState& state, const ServoInput& input) {
  TickStart start;
  start.sample = sample_of(model, state.clutch, input);
  follow_control(model, state, input);

  const bool same_writer = input.contact_generation == state.contact_generation;
  state.contact_generation = input.contact_generation;
  Arrival arrival;
  if (input.contacts != nullptr) {
    arrival = {true, input.contacts->seq, input.contacts->answers_t_ns, same_writer};
  }
  start.age = weigh_contacts(state.age, arrival, input.t_ns, model.dt);

  start.safety = safety_input(model, state, input, start.sample, same_writer);
  if (input.control != nullptr && input.control->paused != 0) start.flags |= kServoPaused;
  if (!is_usable(input.device)) start.flags |= kServoNoDevice;
  start.safety.force_closed |= start.flags != 0;
  start.flags |= start.age.flags;
  if (is_forced(model, state)) start.flags |= kServoForced;
  return start;
}

}  // namespace haptic
