// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/tick.h"

#include <algorithm>
#include <cmath>

#include "proto/config/renderer_needs.h"
#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

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

/// With the first ControlFrame: what was asked of a former servo is no request to this one, and a
/// fault that nobody has cleared since goes on.
void begin_safety(ServoState& state, const ControlFrame& control) {
  if (state.controlled) return;
  state.controlled = true;
  state.safety.fault_clears = control.fault_clears;
  if (state.safety.fault == Fault::kNone) state.safety.fault = static_cast<Fault>(control.fault);
}

HeldBody held_body(const ServoModel& model, const ServoState& state, const ServoInput& input) {
  HeldBody body;
  body.is_wanted =
      is_pressed(input.device, model.map.grasp_button) && !state.clutch.held && !model.admittance;
  const uint32_t object = state.grasp.object;
  if (input.scene == nullptr || object >= kMaxObjects) return body;
  const PushCounters& pushes = state.pushes;
  body.stands = is_mobile(*input.scene, object) &&
                !takes_pushes(*input.scene, kFirstHand, pushes.since_ns, pushes.t_ns);
  return body;
}

Rendered solve_proxy(const ServoModel& model, ServoState& state, const ServoInput& input,
                     TickScene& scene, const Coupling& coupling, ServoFrame& frame) {
  // nothing is known of what a detector without a name has found
  if (input.contacts == nullptr || !is_renderer(input.contacts->renderer)) {
    Rendered none;
    none.X_WP = frame.X_WT;
    return none;
  }
  RenderQuestion question{*input.contacts, scene,        coupling,   frame.X_WT,
                          frame.V_WT,      std::nullopt, input.t_ns, state.soft_solver};
  if (state.started) question.X_WT_before = state.X_WT;
  const Hold hold = hold_of(model, state.grasp, question, held_body(model, state, input));
  draw_tool(hold, state.grasp, question, scene);
  const auto renderer = static_cast<Renderer>(input.contacts->renderer);
  Rendered rendered = rendered_by(renderer, model, question, state.render);
  add_hold(hold, question, rendered);
  // the body of an admittance device stops where the scene does: all that it loses is the object's
  if (!model.admittance &&
      soften_towards_light(model, question, input.scene, state.light, rendered)) {
    frame.flags |= kServoSoftened;
  }
  return rendered;
}

/// The point about which the hand feels the torque of a tool: its handle; of a point, which has
/// none, the proxy.
Vec3 felt_at(const ServoModel& model, const ContactSet* contacts, const Rendered& rendered) {
  const bool is_body = contacts != nullptr && is_renderer(contacts->renderer) &&
                       is_of_body(static_cast<Renderer>(contacts->renderer));
  return is_body ? (rendered.X_WP * inverse(model.map.X_HT)).p : rendered.X_WP.p;
}

}  // namespace

bool is_sound(const DeviceState& device) {
  constexpr double kUnit = 1e-3;
  return is_finite(device.X_BH) && is_finite(device.V_BH) &&
         std::fabs(dot(device.X_BH.q, device.X_BH.q) - 1) < kUnit;
}

bool is_usable(const DeviceState& device) {
  return (device.flags & kDeviceLost) == 0 && (device.flags & kDeviceHomed) != 0;
}

bool note_sample(const ServoInput& input, ServoFrame& frame) {
  frame.tick = input.tick;
  frame.t_ns = input.t_ns;
  frame.realtime_ns = input.realtime_ns;
  frame.wake_late_ns = input.wake_late_ns;
  frame.skipped = input.skipped;
  frame.device = input.device;
  if (!is_finite(input.device.F_hand_B)) frame.device.F_hand_B = {};
  if (is_sound(input.device)) return true;
  frame.device.X_BH = {};
  frame.device.V_BH = {};
  return false;
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
                        input.control->translational_damping,
                        input.control->rotational_stiffness,
                        input.control->rotational_damping,
                        model.coupling.max_force,
                        model.coupling.max_torque};
  state.coupling = ramp_coupling(state.ramp, wanted, model.dt);
  follow_soft_solver(state, input);
}

ContactWeight weigh(ServoState& state, const ServoInput& input, double dt, ServoFrame& frame) {
  ContactArrival arrival;
  if (input.contacts != nullptr) {
    arrival = {true, input.contacts->seq, input.contacts->answers_t_ns,
               input.contact_generation == state.contact_generation};
  }
  state.contact_generation = input.contact_generation;
  const ContactWeight age = weigh_contacts(state.age, arrival, input.t_ns, dt);
  frame.flags |= age.flags;
  frame.fade = age.weight;
  return age;
}

void continue_pushes(const ServoModel& model, PushCounters& pushes, int64_t t_ns) {
  HAPTIC_ASSERT(model.dt > 0);
  if (pushes.since_ns == 0) pushes.since_ns = pushes.t_ns = t_ns;
  const double since = static_cast<double>(t_ns - pushes.t_ns) * 1e-9;
  // an admittance device holds a place, not a force
  const double total = model.admittance ? 0 : std::max(std::round(since / model.dt) - 1, 0.0);
  const double missed = std::min(total, 1.0 * kReleaseAfterTicks);
  // each at its own tick, the first ones: they last for total dt, (total − 1) dt, … until this one
  const double lasting = missed * (total - 0.5 * (missed - 1)) * model.dt;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    pushes.impulse_time_W[i] =
        pushes.impulse_time_W[i] + since * pushes.impulse_W[i] + lasting * pushes.last_W[i];
    pushes.impulse_W[i] = pushes.impulse_W[i] + missed * pushes.last_W[i];
  }
  pushes.last_W = {};
  pushes.t_ns = t_ns;
}

void note_pushes(const ServoModel& model, PushCounters& pushes, const ServoInput& input,
                 const TickScene& placed, const Rendered& rendered, const FeltShare& felt) {
  const SceneFrame* const scene = input.scene;
  const Vec3 at_W = felt_at(model, input.contacts, rendered);
  const bool are_taken =
      scene == nullptr || takes_pushes(*scene, kFirstHand, pushes.since_ns, pushes.t_ns);
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    if (rendered.push_W[i] == Wrench{}) continue;
    const Wrench push_W = shift(rendered.push_W[i], rendered.X_WP.p - at_W);
    const Wrench given_W{-model.dt * felt.force * push_W.f, -model.dt * felt.torque * push_W.t};
    if (are_taken || !is_mobile(*scene, i)) {
      pushes.last_W[i] = shift(given_W, at_W - placed.X_WO[i].p);
      pushes.impulse_W[i] = pushes.impulse_W[i] + pushes.last_W[i];
    } else {
      pushes.forgotten_W += given_W.f;
    }
  }
}

TickScene scene_of(const ServoState& state, const ServoInput& input) {
  TickScene scene;
  if (input.contacts != nullptr) scene.X_WO = input.contacts->X_WO;
  if (input.scene == nullptr) return scene;
  const PushCounters& pushes = state.pushes;
  const HandPush push{kFirstHand, pushes.t_ns, pushes.since_ns, pushes.impulse_W,
                      pushes.impulse_time_W};
  for (uint32_t i = 0; i < std::min(input.scene->n_objects, kMaxObjects); ++i) {
    const UnseenPush unseen = unseen_push(*input.scene, i, input.t_ns, push);
    scene.X_WO[i] = object_pose_at(*input.scene, i, input.t_ns, unseen);
    scene.V_WO[i] = object_twist_at(*input.scene, i, input.t_ns, unseen);
  }
  return scene;
}

bool is_soft_body(const ContactSet* contacts) {
  return contacts != nullptr && is_renderer(contacts->renderer) &&
         row_of(static_cast<Renderer>(contacts->renderer)).moves == Moves::kSoftBody;
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

Rendered render(const ServoModel& model, ServoState& state, const ServoInput& input,
                TickScene& scene, const Coupling& coupling, ServoFrame& frame) {
  Rendered rendered = solve_proxy(model, state, input, scene, coupling, frame);
  if (!rendered.converged) frame.flags |= kServoSolverLimit;
  frame.F_coupling_W = rendered.F_W;
  frame.translational_stiffness = coupling.translational_stiffness;
  frame.rotational_stiffness = coupling.rotational_stiffness;
  if (is_forced(model, state)) frame.flags |= kServoForced;
  frame.X_WP = rendered.X_WP;
  frame.depth = norm(rendered.X_WP.p - frame.X_WT.p);
  frame.n_contacts = static_cast<uint32_t>(rendered.n_pushing);
  if (rendered.n_pushing > 0) frame.flags |= kServoContact;
  return rendered;
}

HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling) {
  const double stiffness = map.force_scale * coupling.translational_stiffness;
  const double lever = norm(map.X_HT.p);
  return {map.motion_scale * stiffness, lever * stiffness,
          map.force_scale * coupling.rotational_stiffness, lever};
}

SafetyInput note_inputs(const ServoModel& model, ServoState& state, const ServoInput& input,
                        ServoFrame& frame) {
  SafetyInput safety;
  safety.device = frame.device;
  safety.released = input.released;
  safety.now_ns = std::max(input.t_ns + input.wake_late_ns, input.device.t_ns);
  const int32_t button = model.dead_man_button;
  safety.armed = button < 0 || is_pressed(input.device, button);
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

void note_safety(ServoState& state, const Rendered& rendered, const SafetyOutput& safe,
                 ServoFrame& frame) {
  frame.flags |= safe.flags;
  frame.fault = static_cast<uint32_t>(state.safety.fault);
  frame.renderer = static_cast<uint32_t>(state.renderer);
  frame.held_back_W = rendered.held_back_W;
  // where nothing is felt nothing holds
  if ((frame.flags & kServoClosed) != 0) {
    state.render.forget();
    state.grasp = {};
    frame.held_back_W = {};
  }
}

void note_frame(ServoState& state, const ServoInput& input, const Rendered& rendered, bool usable,
                ServoFrame& frame) {
  frame.object_impulse_W = state.pushes.impulse_W;
  frame.object_impulse_time_W = state.pushes.impulse_time_W;
  frame.forgotten_impulse_W = state.pushes.forgotten_W;
  frame.impulses_since_ns = state.pushes.since_ns;
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

}  // namespace haptic
