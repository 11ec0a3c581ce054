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
                     const Tool& tool, const Coupling& coupling, Touch& touch) {
  // nothing is known of what a detector without a name has found
  if (input.contacts == nullptr || !is_renderer(input.contacts->renderer)) {
    Rendered none;
    none.X_WP = tool.X_WT;
    return none;
  }
  RenderQuestion question{*input.contacts, touch.scene,  coupling,   tool.X_WT,
                          tool.V_WT,       std::nullopt, input.t_ns, state.soft_solver};
  if (state.started) question.X_WT_before = state.X_WT;
  const Hold hold = hold_of(model, state.grasp, question, held_body(model, state, input));
  draw_tool(hold, state.grasp, question, touch.scene);
  const auto renderer = static_cast<Renderer>(input.contacts->renderer);
  Rendered rendered = rendered_by(renderer, model, question, state.render);
  add_hold(hold, question, rendered);
  // the body of an admittance device stops where the scene does: all that it loses is the object's
  if (!model.admittance &&
      soften_towards_light(model, question, input.scene, state.light, rendered)) {
    touch.flags |= kServoSoftened;
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

/// The objects in this tick: the newest scene carried on by twist and pushes, else where contact
/// saw them.
TickScene scene_of(const ServoState& state, const ServoInput& input, double weight) {
  TickScene scene;
  scene.weight = weight;
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

/// The proxy's velocity where its solver does not know it: its way since the last tick.
Twist velocity_since(const ServoState& state, const Pose& X_WP, int64_t t_ns) {
  const double since = static_cast<double>(t_ns - state.t_ns) * 1e-9;
  if (!state.started || since <= 0) return {};
  return {(X_WP.p - state.X_WP.p) / since, {}};
}

/// Counts what the objects, where they are placed, are pushed with in this tick: the opposite of
/// what they push the proxy with, as far as the hand feels it. What no sim moves a body by is
/// forgotten: it is not given to the body later.
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

/// The flags by which the inputs alone close the force.
uint32_t closing_flags(const ServoInput& input, bool is_clutched) {
  uint32_t flags = 0;
  if (is_clutched) flags |= kServoClutched;
  if (input.control != nullptr && input.control->paused != 0) flags |= kServoPaused;
  if (!is_usable(input.device)) flags |= kServoNoDevice;
  return flags;
}

/// Writes the frame of a tick whose values are all known.
ServoFrame frame_of(const ServoState& state, const ServoInput& input, const ContactWeight& age,
                    const Outcome& outcome, uint32_t flags) {
  ServoFrame frame{};
  frame.tick = input.tick;
  frame.t_ns = input.t_ns;
  frame.realtime_ns = input.realtime_ns;
  frame.wake_late_ns = input.wake_late_ns;
  frame.skipped = input.skipped;
  frame.flags = flags;
  frame.fault = static_cast<uint32_t>(state.safety.fault);
  frame.renderer = static_cast<uint32_t>(state.renderer);

  frame.device = outcome.sample.device;
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
  frame.fade = age.weight;
  frame.F_coupling_W = rendered.F_W;
  frame.translational_stiffness = outcome.touch.coupling.translational_stiffness;
  frame.rotational_stiffness = outcome.touch.coupling.rotational_stiffness;
  frame.X_WP = rendered.X_WP;
  frame.V_WP = outcome.touch.V_WP;
  frame.depth = outcome.touch.depth;
  frame.n_contacts = static_cast<uint32_t>(rendered.n_pushing);
  // where nothing is felt nothing holds
  if ((flags & kServoClosed) == 0) frame.held_back_W = rendered.held_back_W;

  frame.object_impulse_W = state.pushes.impulse_W;
  frame.object_impulse_time_W = state.pushes.impulse_time_W;
  frame.forgotten_impulse_W = state.pushes.forgotten_W;
  frame.impulses_since_ns = state.pushes.since_ns;
  return frame;
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

ContactWeight weigh(ServoState& state, const ServoInput& input, double dt) {
  ContactArrival arrival;
  if (input.contacts != nullptr) {
    arrival = {true, input.contacts->seq, input.contacts->answers_t_ns,
               input.contact_generation == state.contact_generation};
  }
  state.contact_generation = input.contact_generation;
  return weigh_contacts(state.age, arrival, input.t_ns, dt);
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

bool is_soft_body(const ContactSet* contacts) {
  return contacts != nullptr && is_renderer(contacts->renderer) &&
         row_of(static_cast<Renderer>(contacts->renderer)).moves == Moves::kSoftBody;
}

Touch touch_of(const ServoModel& model, ServoState& state, const ServoInput& input,
               const Tool& tool, const Coupling& coupling, double weight) {
  Touch touch;
  touch.scene = scene_of(state, input, weight);
  touch.coupling = coupling;
  const Rendered rendered = solve_proxy(model, state, input, tool, coupling, touch);
  if (!rendered.converged) touch.flags |= kServoSolverLimit;
  if (is_forced(model, state)) touch.flags |= kServoForced;
  if (rendered.n_pushing > 0) touch.flags |= kServoContact;
  touch.V_WP = rendered.V_WP ? *rendered.V_WP : velocity_since(state, rendered.X_WP, input.t_ns);
  touch.depth = norm(rendered.X_WP.p - tool.X_WT.p);
  touch.rendered = rendered;
  return touch;
}

HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling) {
  const double stiffness = map.force_scale * coupling.translational_stiffness;
  const double lever = norm(map.X_HT.p);
  return {map.motion_scale * stiffness, lever * stiffness,
          map.force_scale * coupling.rotational_stiffness, lever};
}

SafetyInput safety_input(const ServoModel& model, ServoState& state, const ServoInput& input,
                         const Sample& sample, bool is_clutched) {
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
    const ReseedMark mark{input.contact_generation, set.reseeds};
    safety.restart = set.reseeds > 0 && mark != state.reseeds;
    state.reseeds = mark;
    safety.force_closed = (set.flags & kContactNoFreePose) != 0;
  }
  safety.force_closed |= closing_flags(input, is_clutched) != 0;
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

ServoFrame settle(const ServoModel& model, ServoState& state, const ServoInput& input,
                  const ContactWeight& age, const Outcome& outcome) {
  const uint32_t flags = age.flags | outcome.touch.flags | outcome.safe.flags | outcome.flags |
                         closing_flags(input, outcome.tool.is_clutched);
  if ((flags & kServoClosed) != 0) {
    state.render.forget();
    state.grasp = {};
  }
  const Touch& touch = outcome.touch;
  if (outcome.felt) {
    note_pushes(model, state.pushes, input, touch.scene, touch.rendered, *outcome.felt);
  }
  const ServoFrame frame = frame_of(state, input, age, outcome, flags);
  state.started = state.started || outcome.sample.usable;
  state.t_ns = input.t_ns;
  if (outcome.sample.usable) state.X_WT = frame.X_WT;
  state.X_WP = frame.X_WP;
  return frame;
}

}  // namespace haptic
