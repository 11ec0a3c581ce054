// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance_tick.h"

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
#include "servo/touch.h"

namespace haptic {
namespace {

constexpr double kOfSpeed = 0.95;  // of the velocity limits: an arm that overshoots is not too fast
constexpr double kFarthest = 2;    // times the velocity limits: no way of one tick
constexpr int kLongestWait = 20;   // ticks until contact has come to a body that is free

/// Starts the body, at rest, where the device is; it keeps its pose while the device is lost.
void begin_body(AdmittanceState& own, const ServoInput& input, const Sample& sample) {
  if (!sample.usable) return;
  if (!own.started) {
    own.body = {sample.device.X_BH, {}};
    own.X_command_B = sample.device.X_BH;
    own.commanded = {};
  }
  own.started = is_usable(input.device);
}

/// True if the arm is where it was commanded to be, as far as its sample says.
bool follows(const ServoModel& model, const AdmittanceState& own, const Sample& sample) {
  const bool is_known = sample.usable && own.started && (sample.device.flags & kDeviceFresh) != 0;
  return !is_known || is_following(own.commanded, own.X_command_B, sample.device.X_BH, model.dt);
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
LedgerLimit free_step(const ServoModel& model, AdmittanceState& own, const Wrench& push_B,
                      const DeviceState& device, bool closed) {
  const SafetyLimits& limits = model.limits;
  if (closed) {
    own.ledger = {};
    return {braked(*model.admittance, own.body, limits.max_force, limits.max_torque, model.dt)};
  }
  const SpeedLimit fastest{kOfSpeed * limits.velocity_limit,
                           kOfSpeed * limits.angular_velocity_limit};
  VirtualBody free = stepped(*model.admittance, own.body, push_B + own.F_scene_B, model.dt);
  free = bounded(own.body, free, fastest, model.dt);
  const Wrench given_B = device.F_hand_B + own.F_scene_B;
  observe_work(own.ledger, given_B, device.X_BH);
  return keep_body_passive(*model.admittance, own.ledger, own.body, free, given_B, model.dt);
}

/// The tool of a body on its way.
Tool tool_of(const ServoModel& model, ServoState& state, const ServoInput& input,
             const VirtualBody& body) {
  DeviceState device = input.device;
  device.X_BH = body.X_BH;
  device.V_BH = body.V_BH;
  return tool_at(model, state, device, state.X_WP);
}

/// The body within the space that contact has looked at: the rest counts as a wall.
VirtualBody kept_in_sight(const ServoModel& model, const ServoState& state, const ServoInput& input,
                          const VirtualBody& from, const VirtualBody& free) {
  const ContactSet* set = input.contacts;
  const double rim = rim_of(set);
  const double seen =
      set != nullptr ? seen_radius(state.admittance.seen, *set, state.age, rim > 0, model.dt) : 0;
  const Pose before = tool_pose(model.map, state.clutch, from.X_BH);
  const Pose wanted = tool_pose(model.map, state.clutch, free.X_BH);
  const Pose kept = kept_within(set != nullptr ? set->X_WG : before, seen, rim, before, wanted);
  if (kept == wanted) return free;
  return brought_to(from, handle_pose(model.map, state.clutch, kept), model.dt);
}

/// Bounds the push of the scene: it may stop the body at once, and turn what moving holds into
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

/// True if the tool goes where contact has proven it free; with the clutch held it goes nowhere.
bool is_led_by_contact(const ServoState& state, const ContactSet* set) {
  const RendererRow* renderer = renderer_of(set);
  return renderer != nullptr && !state.clutch.held && is_rigid(renderer->id);
}

/// The body of a set that is not complete goes where contact has proven the tool free, one tick
/// later, and rests until that is near.
VirtualBody proven_body(const ServoModel& model, const ServoState& state, const ContactSet& set,
                        const VirtualBody& from) {
  if ((set.flags & kContactNoFreePose) != 0) return {from.X_BH, {}};
  const Pose X_WT = tool_pose(model.map, state.clutch, from.X_BH);
  if (norm(set.X_WG.p - X_WT.p) > kLeastSeen) return {from.X_BH, {}};
  const Pose X_BH = handle_pose(model.map, state.clutch, set.X_WG);
  return brought_to(from, {X_BH.p, normalized(X_BH.q)}, model.dt);
}

/// The region that contact has proven free for a point or a sphere; it is everywhere where the tool
/// is a body, and with the clutch held, when the tool goes nowhere.
FreeRegion proven_region(const ServoModel& model, const ServoState& state, const ContactSet* set,
                         const TickScene& scene) {
  const RendererRow* renderer = renderer_of(set);
  if (renderer == nullptr || is_of_body(renderer->id) || state.clutch.held) return {};
  const bool is_sphere = renderer->moves == Moves::kSphere;
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
                        const Touch& touch, const Pose& X_WT, const VirtualBody& from,
                        const VirtualBody& free) {
  if (!state.admittance.contacts_finite) return {from.X_BH, {}};
  const ContactSet* set = input.contacts;
  const bool is_cut = set != nullptr && (set->flags & kContactTruncated) != 0;
  if (is_cut && !state.clutch.held && !is_led_by_contact(state, set)) {
    return proven_body(model, state, *set, from);
  }
  const FreeRegion region = proven_region(model, state, set, touch.scene);
  // the way through the scene and back rounds
  const Pose& X_WP = touch.rendered.X_WP;
  if (X_WP == X_WT && holds(region, X_WT.p)) {
    state.admittance.waited = 0;
    return free;
  }
  return kept_free(model, state, region, from, free, X_WP);
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

/// The pose that the device is sent to. The planes around a rigid tool hold to first order of its
/// turn, so it goes where contact has proven it free, a tick later. Where nothing is proven it
/// stays, and the body begins anew.
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

/// Passes the measured force and torque of the hand through safety; nothing is left while
/// contacts fade or are stale.
SafetyOutput safe_push(const ServoModel& model, ServoState& state, const ServoInput& input,
                       const TickStart& start) {
  AdmittanceState& own = state.admittance;
  // a clutch that is held closes nothing: the body moves on, and the tool stays
  SafetyInput safety = start.safety;
  safety.F_B = input.device.F_hand_B;
  safety.device_follows = follows(model, own, start.sample);
  safety.contacts_finite = own.contacts_finite;
  SafetyOutput safe = make_safe(model.limits, state.safety, safety, model.dt);
  // the body begins anew where an arm is held: nothing pulls at it, nor throws it when it comes
  // free
  if (state.safety.fault == Fault::kDeviceStale && !safety.device_follows) own.started = false;
  safe.closed = safe.closed || (start.age.flags & (kServoFading | kServoStale)) != 0;
  return safe;
}

/// Sends the device to the body, or where contact has proven it free.
void command(const ServoModel& model, ServoState& state, const ServoInput& input, Outcome& out) {
  AdmittanceState& own = state.admittance;
  out.X_command_B = command_of(model, state, input.contacts);
  note_way(own.commanded, own.X_command_B, out.X_command_B);
  own.X_command_B = out.X_command_B;
  const bool waits = own.waited > 0;
  // where nothing is rendered contact begins anew, at the tool; where it is waited for it comes
  if (out.safe.closed || waits) out.tool.X_WT = tool_pose(model.map, state.clutch, own.body.X_BH);
  if (waits) {
    out.tool.V_WT = {};
    out.touch.rendered.held_back_W = {};
  }
  const double rim = rim_of(input.contacts);
  note_asked(own.seen, input.tick,
             std::max(largest_travel(out.tool.V_WT, rim), largest_travel(out.touch.V_WP, rim)));
}

}  // namespace

Outcome admittance_tick(const ServoModel& model, ServoState& state, const ServoInput& input,
                        const TickStart& start) {
  const DeviceState& device = start.sample.device;
  Outcome out;
  AdmittanceState& own = state.admittance;
  rest_after_gap(model, own, input);
  begin_body(own, input, start.sample);
  out.X_WG = tool_pose(model.map, state.clutch, own.body.X_BH);
  out.safe = safe_push(model, state, input, start);
  const bool closed = out.safe.closed;
  const Wrench push_B = (closed ? 0 : start.age.weight) * out.safe.F_B;

  // the free step of the body, then what the scene leaves of it
  const VirtualBody before = own.body;
  const LedgerLimit passive = free_step(model, own, push_B, device, closed);
  if (passive.damped) out.flags |= kServoPassivity;
  const bool is_soft = is_soft_body(input.contacts);
  const VirtualBody free =
      is_soft ? passive.body : kept_in_sight(model, state, input, before, passive.body);
  out.tool = tool_of(model, state, input, free);
  const Coupling coupling = is_soft ? state.coupling : inertial_coupling(model);
  out.touch = touch_of(model, state, input, out.tool, coupling, 1);
  const Rendered& rendered = out.touch.rendered;
  own.contacts_finite = rendered.finite && is_finite(rendered.X_WP) && is_finite(rendered.F_W);
  own.body =
      is_soft ? free : constrained(model, state, input, out.touch, out.tool.X_WT, before, free);
  own.F_scene_B = is_soft && !closed ? scene_push(model, state, rendered) : Wrench{};
  // what the scene holds back is what the hand pushes it with
  out.safe.felt = closed ? FeltShare{} : FeltShare{1, 1};
  if (!closed) {
    settle_ledger(*model.admittance, own.ledger, free, own.body, device.F_hand_B + own.F_scene_B,
                  model.dt);
  }
  out.F_device_B = -push_B;
  command(model, state, input, out);
  return out;
}

}  // namespace haptic
