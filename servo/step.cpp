// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/step.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

/// Finite, and the orientation is a rotation.
bool is_sound(const DeviceState& device) {
  constexpr double kUnit = 1e-3;
  return is_finite(device.X_BH) && is_finite(device.V_BH) &&
         std::fabs(dot(device.X_BH.q, device.X_BH.q) - 1) < kUnit;
}

/// Whether a force may follow from where the device says it is.
bool is_usable(const DeviceState& device) {
  return (device.flags & kDeviceLost) == 0 && (device.flags & kDeviceHomed) != 0;
}

/// Where the objects are this tick: the newest scene extrapolated, else where contact saw them.
TickScene scene_of(const ServoInput& input) {
  TickScene scene;
  if (input.contacts != nullptr) scene.X_WO = input.contacts->X_WO;
  if (input.scene == nullptr) return scene;
  for (uint32_t i = 0; i < std::min(input.scene->n_objects, kMaxObjects); ++i) {
    scene.X_WO[i] = object_pose_at(*input.scene, i, input.t_ns);
    scene.V_WO[i] = object_twist_at(*input.scene, i, input.t_ns);
  }
  return scene;
}

ContactWeight weigh(ServoState& state, const ServoInput& input, double dt) {
  ContactArrival arrival;
  if (input.contacts != nullptr) {
    arrival = {true, input.contacts->seq, input.contacts->answers_t_ns,
               input.contact_generation == state.contact_generation};
  }
  state.contact_generation = input.contact_generation;
  return weigh_contacts(state.age, arrival, input.t_ns, dt);
}

bool is_soft_body(const ContactSet* contacts) {
  return contacts != nullptr && is_renderer(contacts->renderer) &&
         row_of(static_cast<Renderer>(contacts->renderer)).moves == Moves::kSoftBody;
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
                        input.control->translational_damping, input.control->rotational_stiffness,
                        input.control->rotational_damping};
  state.coupling = ramp_coupling(state.ramp, wanted, model.dt);
  follow_soft_solver(state, input);
}

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

/// The coupling in force as the handle would feel it.
HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling) {
  const double stiffness = map.force_scale * coupling.translational_stiffness;
  const double lever = norm(map.X_HT.p);
  return {map.motion_scale * stiffness, lever * stiffness,
          map.force_scale * coupling.rotational_stiffness, lever};
}

/// Fills in what is known before contacts. False when the device sample cannot be used: the tool
/// then keeps its last good pose.
bool begin_frame(const ServoModel& model, ServoState& state, const ServoInput& input,
                 ServoFrame& frame) {
  frame.tick = input.tick;
  frame.t_ns = input.t_ns;
  frame.realtime_ns = input.realtime_ns;
  frame.wake_late_ns = input.wake_late_ns;
  frame.skipped = input.skipped;
  frame.device = input.device;
  // a finite but absurd sample may overflow on its way into the scene
  const Pose X_WT = tool_pose(model.map, state.clutch, input.device.X_BH);
  const Twist V_WT = tool_twist(model.map, input.device.X_BH, input.device.V_BH);
  if (!is_sound(input.device) || !is_finite(X_WT) || !is_finite(V_WT)) {
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

/// With the first ControlFrame: what was asked of a former servo is no request to this one, and a
/// fault that nobody has cleared since goes on.
void begin_safety(ServoState& state, const ControlFrame& control) {
  if (state.controlled) return;
  state.controlled = true;
  state.safety.fault_clears = control.fault_clears;
  if (state.safety.fault == Fault::kNone) state.safety.fault = static_cast<Fault>(control.fault);
}

/// By the solver that goes with the detector of the contacts; it begins with nothing of another's.
Rendered render(const ServoModel& model, ServoState& state, const ServoInput& input,
                const TickScene& scene, const ServoFrame& frame) {
  // nothing is known of what a detector without a name has found
  if (input.contacts == nullptr || !is_renderer(input.contacts->renderer)) {
    Rendered none;
    none.X_WP = frame.X_WT;
    none.object_impulse_W = state.object_impulse_W;
    return none;
  }
  Render& solver = render_of(static_cast<Renderer>(input.contacts->renderer));
  if (state.solver != &solver) state.render.forget();
  state.solver = &solver;
  RenderQuestion question{*input.contacts, scene,      state.object_impulse_W,
                          state.coupling,  frame.X_WT, frame.V_WT,
                          std::nullopt,    input.t_ns, state.soft_solver};
  if (state.started) question.X_WT_before = state.X_WT;
  return solver(model, question, state.render);
}

/// Notes in the frame which inputs it used, and what they ask of safety.
SafetyInput note_inputs(const ServoModel& model, ServoState& state, const ServoInput& input,
                        ServoFrame& frame) {
  SafetyInput safety;
  safety.device = frame.device;
  safety.released = input.released;
  safety.now_ns = std::max(input.t_ns + input.wake_late_ns, input.device.t_ns);
  const int32_t button = model.dead_man_button;
  safety.armed = button < 0 || ((input.device.buttons >> button) & 1u) != 0;
  frame.X_WG = frame.X_WT;  // nothing is verified before the first set, and the flags say so
  safety.force_closed = input.contacts == nullptr;
  if (input.contacts != nullptr) {
    const ContactSet& set = *input.contacts;
    frame.contact_seq = set.seq;
    frame.contact_tick = set.answers_tick;
    frame.X_WG = set.X_WG;
    // a count, not an event: the set that placed the proxy anew may have been overwritten unread
    const ReseedMark mark{input.contact_generation, set.reseeds};
    safety.restart = set.reseeds > 0 && mark != state.reseeds;
    state.reseeds = mark;
    safety.force_closed = (set.flags & kContactNoFreePose) != 0;
  }
  if (input.scene != nullptr) frame.scene_seq = input.scene->seq;
  // nobody has said yet that this hand may feel anything
  safety.armed &= input.control != nullptr && input.control->armed != 0;
  if (input.control != nullptr) {
    begin_safety(state, *input.control);
    frame.control_revision = input.control->revision;
    safety.fault_clears = input.control->fault_clears;
    if (input.control->paused != 0) frame.flags |= kServoPaused;
  }
  if (!is_usable(input.device)) frame.flags |= kServoNoDevice;
  safety.force_closed |= (frame.flags & (kServoClutched | kServoPaused | kServoNoDevice)) != 0;
  return safety;
}

/// What the device is told to hold, and what follows from its being closed.
void hold_wrench(ServoState& state, const Rendered& rendered, const SafetyOutput& safe,
                 ServoFrame& frame) {
  frame.F_device_B = safe.F_B;
  frame.X_command_B = frame.device.X_BH;
  frame.flags |= safe.flags;
  frame.fault = static_cast<uint32_t>(state.safety.fault);
  frame.renderer = static_cast<uint32_t>(state.renderer);
  frame.held_back_W = rendered.held_back_W;
  // where nothing is felt nothing holds
  if ((frame.flags & kServoClosed) != 0) {
    state.render.forget();
    frame.held_back_W = {};
  }
  // contact must not lead the verified proxy to where the hand cannot be, round an object perhaps
  if (state.safety.jumped) {
    frame.X_WT = state.X_WT;
    frame.V_WT = {};
  }
}

/// The proxy's velocity since the last tick, and what the next one needs of this.
void note_frame(ServoState& state, const ServoInput& input, const Rendered& rendered, bool usable,
                ServoFrame& frame) {
  if (rendered.V_WP) {
    frame.V_WP = *rendered.V_WP;
  } else if (state.started) {
    const double since = static_cast<double>(input.t_ns - state.t_ns) * 1e-9;
    if (since > 0) frame.V_WP.v = (frame.X_WP.p - state.X_WP.p) / since;
  }
  state.started = state.started || usable;
  state.t_ns = input.t_ns;
  if (usable) state.X_WT = frame.X_WT;
  state.X_WP = frame.X_WP;
}

/// What is known before contact has baked the tool.
SoftProxyModel body_model(const SessionConfig& config) {
  SoftProxyModel body;
  body.integrator = config.proxy.integrator;
  body.tool.mass = config.tool.mass;
  body.coupling.max_force = config.coupling.max_force;
  body.coupling.max_torque = config.coupling.max_torque;
  body.contact_stiffness = config.proxy.contact_stiffness;
  body.contact_damping = config.proxy.contact_damping;
  // a point moves at most half the band in a tick, so that none passes it unseen; without a field
  // a voxel, as McNeely has it
  body.max_travel = config.voxel.field != 0 ? 0.5 * config.voxel.band : config.voxel.size;
  return body;
}

}  // namespace

ServoModel build_servo_model(const SessionConfig& config, const ActuatorLimits& device) {
  HAPTIC_ASSERT(config.servo_rate > 0 && config.n_objects <= kMaxObjects);
  HAPTIC_ASSERT(device.max_force >= 0 && device.max_torque >= 0);
  ServoModel model;
  model.dt = 1 / config.servo_rate;
  model.map = config.map;
  model.coupling = {config.coupling.translational_stiffness, config.coupling.translational_damping,
                    config.coupling.rotational_stiffness, config.coupling.rotational_damping};
  model.dead_man_button = config.safety.dead_man_button;
  model.renderer = config.renderer;
  model.virtual_proxy.radius = config.proxy_radius;
  model.virtual_proxy.images = config.images;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.virtual_proxy.materials[i] = config.objects[i].material;
  }
  model.proxy = config.proxy;
  model.rigid_solver = config.rigid.solver;
  model.body = body_model(config);
  SafetyLimits& limits = model.limits;
  limits.max_force = std::min(config.safety.max_force, device.max_force);
  limits.max_torque = std::min(config.safety.max_torque, device.max_torque);
  limits.soft_start = config.safety.soft_start;
  limits.continuous_force = config.device.continuous_force;
  limits.continuous_torque = config.device.continuous_torque;
  limits.slew = config.safety.slew;
  limits.torque_slew = config.safety.torque_slew;
  limits.velocity_limit = config.safety.velocity_limit;
  limits.angular_velocity_limit = config.safety.angular_velocity_limit;
  limits.workspace_centre_B = config.device.workspace_centre_B;
  limits.workspace_radius = config.device.workspace_radius;
  limits.workspace_rest_B = config.device.workspace_rest_B;
  limits.workspace_turn = config.device.workspace_turn;
  limits.max_damping = config.device.max_damping;
  limits.max_rotational_damping = config.device.max_rotational_damping;
  return model;
}

ServoFrame servo_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  HAPTIC_ASSERT(model.dt > 0 && model.dead_man_button < 32);
  ServoFrame frame{};
  const bool usable = begin_frame(model, state, input, frame);
  follow_control(model, state, input);

  // contacts where the objects are now, as far as their age allows
  const ContactWeight age = weigh(state, input, model.dt);
  frame.flags |= age.flags;
  frame.fade = age.weight;
  TickScene scene = scene_of(input);
  scene.weight = age.weight;
  const Rendered rendered = render(model, state, input, scene, frame);
  if (!rendered.converged) frame.flags |= kServoSolverLimit;
  frame.F_coupling_W = rendered.F_W;
  frame.translational_stiffness = state.coupling.translational_stiffness;
  frame.rotational_stiffness = state.coupling.rotational_stiffness;
  frame.X_WP = rendered.X_WP;
  frame.depth = norm(rendered.X_WP.p - frame.X_WT.p);
  frame.n_contacts = static_cast<uint32_t>(rendered.n_pushing);
  if (rendered.n_pushing > 0) frame.flags |= kServoContact;

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
  // a closed force pushes nothing
  const bool felt = !safety.force_closed && (safe.flags & kServoFault) == 0;
  if (felt) state.object_impulse_W = rendered.object_impulse_W;
  frame.object_impulse_W = state.object_impulse_W;

  note_frame(state, input, rendered, usable, frame);
  return frame;
}

}  // namespace haptic
