// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance_step.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "servo/admittance/following.h"
#include "servo/admittance/free_region.h"
#include "servo/tick.h"

namespace haptic {
namespace {

constexpr double kOfSpeed = 0.95;  // of the velocity limits: an arm that overshoots is not too fast
constexpr double kFarthest = 2;    // times the velocity limits: no way of one tick
constexpr int kLongestWait = 20;   // ticks until contact has come to a body that is free

/// Starts the body, at rest, where the device is; it keeps its pose while the device is lost.
bool take_sample(const ServoModel& model, AdmittanceState& own, const ServoInput& input,
                 ServoFrame& frame) {
  bool usable = note_sample(input, frame);
  usable = usable && is_finite(tool_pose(model.map, {}, frame.device.X_BH));
  if (usable && !own.started) {
    own.body = {frame.device.X_BH, {}};
    own.X_command_B = frame.device.X_BH;
    own.commanded = {};
  }
  if (usable) own.started = is_usable(input.device);
  return usable;
}

/// Whether the arm is where it was commanded to be.
bool follows(const ServoModel& model, const AdmittanceState& own, const ServoFrame& frame) {
  if (!own.started || (frame.device.flags & kDeviceFresh) == 0) return true;
  return is_following(own.commanded, own.X_command_B, frame.device.X_BH, model.dt);
}

/// After skipped ticks, and in a tick so late that the next is skipped, the body is at rest, as the
/// arm is, which holds its last command. Going on at the former speed would throw the hand, whose
/// work would then be missing from the ledger.
void rest_after_gap(const ServoModel& model, AdmittanceState& own, const ServoInput& input) {
  const bool is_late = 1e-9 * static_cast<double>(input.wake_late_ns) >= model.dt;
  if (own.started && (is_late || input.tick > own.tick + 1)) {
    own.body.V_BH = {};
    own.ledger = {};
  }
  own.tick = input.tick;
}

/// The spring of the proxy, which is the inertia of one tick, in the scene.
Coupling inertial_coupling(const ServoModel& model) {
  const DeviceMap& map = model.map;
  const double scale = map.force_scale * model.dt * model.dt;
  Coupling coupling;
  coupling.translational_stiffness = model.admittance->mass / (scale * map.motion_scale);
  coupling.rotational_stiffness = model.admittance->inertia / scale;
  return coupling;
}

/// Distance of the tool's farthest point from its origin [m].
double rim_of(const ContactSet* contacts) {
  return contacts != nullptr ? norm(contacts->tool.centre_T) + contacts->tool.radius : 0;
}

/// The body's step with what moves it, before the scene stops it.
VirtualBody free_step(const ServoModel& model, AdmittanceState& own, const Wrench& push_B,
                      const DeviceState& device, bool closed, ServoFrame& frame) {
  const SafetyLimits& limits = model.limits;
  if (closed) {
    own.ledger = {};
    return braked(*model.admittance, own.body, limits.max_force, limits.max_torque, model.dt);
  }
  const SpeedLimit fastest{kOfSpeed * limits.velocity_limit,
                           kOfSpeed * limits.angular_velocity_limit};
  VirtualBody free = stepped(*model.admittance, own.body, push_B + own.F_scene_B, model.dt);
  free = bounded(own.body, free, fastest, model.dt);
  const Wrench given_B = device.F_hand_B + own.F_scene_B;
  observe_work(own.ledger, given_B, device.X_BH);
  const LedgerLimit passive =
      keep_body_passive(*model.admittance, own.ledger, own.body, free, given_B, model.dt);
  if (passive.damped) frame.flags |= kServoPassivity;
  return passive.body;
}

/// The tool of a body on its way; the clutch moves the workspace instead, and the tool stays.
void place_shown_tool(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const VirtualBody& body, ServoFrame& frame) {
  DeviceState device = input.device;
  device.X_BH = body.X_BH;
  const Pose X_WT = tool_pose(model.map, state.clutch, body.X_BH);
  frame.X_WT = apply_clutch(model.map, state.clutch, device, state.started ? state.X_WP : X_WT);
  frame.V_WT = tool_twist(model.map, body.X_BH, body.V_BH);
  if (!state.clutch.held) return;
  frame.V_WT = {};
  frame.flags |= kServoClutched;
}

/// What nobody has looked at counts as a wall.
void stay_in_sight(const ServoModel& model, const ServoState& state, const ServoInput& input,
                   const VirtualBody& from, VirtualBody& free) {
  const ContactSet* set = input.contacts;
  const double rim = rim_of(set);
  const double seen =
      set != nullptr ? seen_radius(state.admittance.seen, *set, state.age, rim > 0, model.dt) : 0;
  const Pose before = tool_pose(model.map, state.clutch, from.X_BH);
  const Pose wanted = tool_pose(model.map, state.clutch, free.X_BH);
  const Pose kept = kept_within(set != nullptr ? set->X_WG : before, seen, rim, before, wanted);
  if (kept == wanted) return;
  free = brought_to(from, handle_pose(model.map, state.clutch, kept), model.dt);
}

/// How much the scene may push: it may stop the body at once, and turn what moving holds into
/// turning, but not throw it. The shortened way ends between both poses: a point is free there,
/// since the region that both lie in is convex; a rigid tool is commanded where contact has proven
/// it.
VirtualBody pushed(const ServoModel& model, const VirtualBody& from, const VirtualBody& free,
                   const VirtualBody& proxy) {
  const AdmittanceConfig& m = *model.admittance;
  const BodyEnergy energy = energy_of(m, free.V_BH);
  const double speed = std::sqrt(2 * (energy.moving + energy.turning));
  const auto share_of = [&](double inertia, double push, double is) {
    const double most = speed / std::sqrt(inertia) + model.dt * push / inertia;
    return is > most ? most / is : 1;
  };
  const double share = std::min(share_of(m.mass, model.limits.max_force, norm(proxy.V_BH.v)),
                                share_of(m.inertia, model.limits.max_torque, norm(proxy.V_BH.w)));
  if (share == 1) return proxy;
  const Twist V_B = share * proxy.V_BH;
  return {moved(from.X_BH, model.dt * V_B), V_B};
}

/// Whether the tool goes where contact has proven it free; with the clutch held it goes nowhere.
bool is_led_by_contact(const ServoState& state, const ContactSet* set) {
  return set != nullptr && is_renderer(set->renderer) && !state.clutch.held &&
         is_rigid(static_cast<Renderer>(set->renderer));
}

/// Where contacts are not complete: where contact has proven the tool free, one tick later, and at
/// rest until that is near.
VirtualBody proven_body(const ServoModel& model, const ServoState& state, const ContactSet& set,
                        const VirtualBody& from) {
  if ((set.flags & kContactNoFreePose) != 0) return {from.X_BH, {}};
  const Pose X_WT = tool_pose(model.map, state.clutch, from.X_BH);
  if (norm(set.X_WG.p - X_WT.p) > kLeastSeen) return {from.X_BH, {}};
  const Pose X_BH = handle_pose(model.map, state.clutch, set.X_WG);
  return brought_to(from, {X_BH.p, normalized(X_BH.q)}, model.dt);
}

/// Where contact has proven a point or a sphere free; everywhere where the tool is a body, and with
/// the clutch held, when the tool goes nowhere.
FreeRegion proven_region(const ServoModel& model, const ServoState& state, const ContactSet* set,
                         const TickScene& scene) {
  if (set == nullptr || !is_renderer(set->renderer) || state.clutch.held) return {};
  const auto renderer = static_cast<Renderer>(set->renderer);
  if (is_of_body(renderer)) return {};
  const bool is_sphere = row_of(renderer).moves == Moves::kSphere;
  return free_region(*set, scene, is_sphere ? model.proxy_radius : 0);
}

/// The body brought to the pose whose tool is at X_WP.
VirtualBody brought_to_proxy(const ServoModel& model, const ServoState& state,
                             const VirtualBody& from, const Pose& X_WP) {
  const Pose X_BH = handle_pose(model.map, state.clutch, X_WP);
  return brought_to(from, {X_BH.p, normalized(X_BH.q)}, model.dt);
}

/// A point goes from place to place of what is proven free. Where the solver lets it past the rim
/// of a plane, it stays in front of it until contact has come to that place. A body that is not
/// where contact is, since friction holds it back before an edge, waits until contact has come to
/// it; if that takes too long it is inside of an object, and is pushed out.
VirtualBody kept_free(const ServoModel& model, ServoState& state, const FreeRegion& region,
                      const VirtualBody& from, const VirtualBody& free, Pose X_WP) {
  const int waited = std::exchange(state.admittance.waited, 0);
  if (holds(region, tool_pose(model.map, state.clutch, from.X_BH).p)) {
    if (!holds(region, X_WP.p)) X_WP.p = brought_into(region, X_WP.p);
    return pushed(model, from, free, brought_to_proxy(model, state, from, X_WP));
  }
  const VirtualBody proxy = brought_to_proxy(model, state, from, X_WP);
  const VirtualBody to = pushed(model, from, free, proxy);
  const bool is_proven = to.X_BH == proxy.X_BH && holds(region, X_WP.p);
  if (is_proven || waited >= kLongestWait) return to;
  state.admittance.waited = waited + 1;
  return {from.X_BH, {}};
}

/// The body as the scene lets it go. Contacts that are not finite say nothing: it stays.
VirtualBody constrained(const ServoModel& model, ServoState& state, const ServoInput& input,
                        const TickScene& scene, const Rendered& rendered, const Pose& X_WT,
                        const VirtualBody& from, const VirtualBody& free) {
  if (!state.admittance.contacts_finite) return {from.X_BH, {}};
  const ContactSet* set = input.contacts;
  const bool is_cut = set != nullptr && (set->flags & kContactTruncated) != 0;
  if (is_cut && !state.clutch.held && !is_led_by_contact(state, set)) {
    return proven_body(model, state, *set, from);
  }
  const FreeRegion region = proven_region(model, state, set, scene);
  // the way through the scene and back rounds
  if (rendered.X_WP == X_WT && holds(region, X_WT.p)) {
    state.admittance.waited = 0;
    return free;
  }
  return kept_free(model, state, region, from, free, rendered.X_WP);
}

/// The handle where contact has proven the tool free; none where nothing is proven, or where the
/// arm cannot have come from the last command.
std::optional<Pose> proven_pose(const ServoModel& model, const ServoState& state,
                                const ContactSet& set) {
  if ((set.flags & kContactNoFreePose) != 0) return std::nullopt;
  const Pose X_BH = handle_pose(model.map, state.clutch, set.X_WG);
  const Twist way = way_between(state.admittance.X_command_B, X_BH);
  const double moving = kFarthest * model.dt * model.limits.velocity_limit;
  const double turning = kFarthest * model.dt * model.limits.angular_velocity_limit;
  if (norm(way.v) > moving || norm(way.w) > turning) return std::nullopt;
  return Pose{X_BH.p, normalized(X_BH.q)};
}

/// Where the device is sent. The planes around a rigid tool hold to first order of its turn, so it
/// goes where contact has proven it free, a tick later. Where nothing is proven it stays, and the
/// body begins anew.
Pose command_of(const ServoModel& model, ServoState& state, const ContactSet* set) {
  AdmittanceState& own = state.admittance;
  if (!is_led_by_contact(state, set)) return own.body.X_BH;
  const std::optional<Pose> X_BH = proven_pose(model, state, *set);
  if (X_BH) return *X_BH;
  own.body = {own.X_command_B, {}};
  return own.X_command_B;
}

/// The wrench with which a soft body's springs push the body, no more than the device may.
Wrench scene_push(const ServoModel& model, const ServoState& state, const Rendered& rendered) {
  if (!state.admittance.contacts_finite) return {};
  Wrench F_B = device_wrench(model.map, state.admittance.body.X_BH, rendered.F_W);
  saturate(F_B, {model.limits.max_force, model.limits.max_torque});
  return F_B;
}

/// Returns what safety judges in this tick: the force and torque of the hand as measured, and
/// whether the device follows and device and contacts gave finite numbers.
SafetyInput hand_push(const ServoModel& model, ServoState& state, const ServoInput& input,
                      bool usable, ServoFrame& frame) {
  SafetyInput safety = note_inputs(model, state, input, frame);
  safety.F_B = input.device.F_hand_B;
  safety.stiffness = handle_stiffness(model.map, state.coupling);
  safety.device_finite = usable;
  safety.device_follows = !usable || follows(model, state.admittance, frame);
  safety.contacts_finite = state.admittance.contacts_finite;
  safety.letting_go = state.letting_go;
  return safety;
}

}  // namespace

ServoFrame admittance_step(const ServoModel& model, ServoState& state, const ServoInput& input) {
  ServoFrame frame{};
  AdmittanceState& own = state.admittance;
  rest_after_gap(model, own, input);
  const bool usable = take_sample(model, own, input, frame);
  follow_control(model, state, input);
  continue_pushes(model, state.pushes, input.t_ns);
  const ContactWeight age = weigh(state, input, model.dt, frame);
  frame.X_WT = tool_pose(model.map, state.clutch, own.body.X_BH);

  const SafetyInput safety = hand_push(model, state, input, usable, frame);
  const SafetyOutput safe = make_safe(model.limits, state.safety, safety, model.dt);
  // the body begins anew where an arm is held: nothing pulls at it, nor throws it when it comes
  // free
  const bool is_held = state.safety.fault == Fault::kDeviceStale && !safety.device_follows;
  own.started = own.started && !is_held;
  const bool closed = safe.closed || (age.flags & (kServoFading | kServoStale)) != 0;
  const Wrench push_B = (closed ? 0 : age.weight) * safe.F_B;

  // the free step of the body, then what the scene leaves of it
  const VirtualBody before = own.body;
  VirtualBody free = free_step(model, own, push_B, frame.device, closed, frame);
  const bool is_soft = is_soft_body(input.contacts);
  if (!is_soft) stay_in_sight(model, state, input, before, free);
  place_shown_tool(model, state, input, free, frame);
  TickScene scene = scene_of(state, input);
  const Coupling coupling = is_soft ? state.coupling : inertial_coupling(model);
  const Rendered rendered = render(model, state, input, scene, coupling, frame);
  own.contacts_finite = rendered.finite && is_finite(rendered.X_WP) && is_finite(rendered.F_W);
  own.body =
      is_soft ? free : constrained(model, state, input, scene, rendered, frame.X_WT, before, free);
  own.F_scene_B = is_soft && !closed ? scene_push(model, state, rendered) : Wrench{};
  if (!closed) {
    settle_ledger(*model.admittance, own.ledger, free, own.body,
                  frame.device.F_hand_B + own.F_scene_B, model.dt);
  }

  note_safety(state, rendered, safe, frame);
  frame.F_device_B = -push_B;
  frame.X_command_B = command_of(model, state, input.contacts);
  note_way(own.commanded, own.X_command_B, frame.X_command_B);
  own.X_command_B = frame.X_command_B;
  // where nothing is rendered contact begins anew, at the tool; where it is waited for it comes
  if (closed || own.waited > 0) frame.X_WT = tool_pose(model.map, state.clutch, own.body.X_BH);
  if (own.waited > 0) {
    frame.V_WT = {};
    frame.held_back_W = {};
  }
  // what the scene holds back is what the hand pushes it with
  if (!closed) note_pushes(model, state.pushes, input, scene, rendered, {1, 1});
  note_frame(state, input, rendered, usable, frame);
  const double rim = rim_of(input.contacts);
  note_asked(own.seen, input.tick,
             std::max(largest_travel(frame.V_WT, rim), largest_travel(frame.V_WP, rim)));
  return frame;
}

}  // namespace haptic
