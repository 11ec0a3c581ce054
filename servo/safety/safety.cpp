// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/safety.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// 1. faults and 2. closed
constexpr double kHuge = 1000;      // times the limit: no wall pushes that hard
constexpr double kJumpSpeed = 2;    // times the velocity limit
constexpr double kCalm = 0.1;       // slow enough to start again [m/s]
constexpr double kCalmTurning = 1;  // the same for turning: 0.1 m/s at 100 mm [rad/s]
// 3. edge and soft start
constexpr double kEdgeShare = 0.3;    // largest force of the workspace edge over max_force
constexpr double kEdgeWidth = 5e-3;   // way over which the edge's spring reaches that [m]
constexpr double kEdgeAngle = 50e-3;  // the same for turning: 5 mm at 100 mm [rad]
constexpr double kLetGoTime = 0.05;   // in which a force is let go, as that of old contacts [s]
// 4. saturation
constexpr double kThermalTime = 10;     // time constant of the thermal low-pass [s]
constexpr double kThermalBand = 0.2;    // last part of the budget, over which the limit falls
constexpr double kBelow = 1 - 0x1p-50;  // slightly less than 1: rounding must not exceed a limit
// 6. passivity
constexpr double kForgetTime = 0.5;      // decay of a deficit in free space [s]
constexpr double kStill = 1e-3;          // slower than this there is nothing to damp [m/s]
constexpr double kStillTurning = 10e-3;  // the same for turning: 1 mm/s at 100 mm [rad/s]

/// How far the handle has moved from the last fresh sample to this one; not where this one is not
/// fresh.
struct HandleStep {
  double way = 0;       // [m]
  double turn = 0;      // [rad]
  bool jumped = false;  // farther than the hand can have moved
};

bool is_turning_felt(const SafetyLimits& limits, const HandleStiffness& stiffness) {
  return limits.max_torque > 0 || stiffness.turning > 0;
}

/// Compares a sample that is finite with the last fresh one. Homing, and a device that comes back,
/// move the pose rightly.
HandleStep follow_handle(const SafetyLimits& limits, LastSample& last, const SafetyInput& input) {
  const DeviceState& device = input.device;
  const bool known = (device.flags & kDeviceHomed) != 0 && (device.flags & kDeviceLost) == 0;
  if (!known) last.known = false;
  if (!known || (device.flags & kDeviceFresh) == 0) return {};
  HandleStep step;
  if (last.known) {
    step.way = norm(device.X_BH.p - last.X_BH.p);
    step.turn = norm(to_rotation_vector(device.X_BH.q * conjugate(last.X_BH.q)));
    // up to now, since a late sample may be of any instant in between
    const double since = std::max(static_cast<double>(input.now_ns - last.measured_ns) * 1e-9, 0.0);
    const double farthest = kJumpWay + kJumpSpeed * limits.velocity_limit * since;
    const double widest = kJumpTurn + kJumpSpeed * limits.angular_velocity_limit * since;
    step.jumped =
        step.way > farthest || (is_turning_felt(limits, input.stiffness) && step.turn > widest);
  }
  last = {device.X_BH, device.t_ns, true};
  return step;
}

Fault find_fault(const SafetyLimits& limits, const HandleStep& step, const SafetyInput& input) {
  if (!input.device_finite) return Fault::kDeviceNotFinite;
  if (!input.contacts_finite) return Fault::kContactsNotFinite;
  if (!is_finite(input.F_B)) return Fault::kForceNotFinite;
  if (step.jumped) return Fault::kPoseJump;
  if ((input.device.flags & kDeviceStale) != 0 || !input.device_follows) return Fault::kDeviceStale;
  if ((input.device.flags & kDeviceNoisy) != 0) return Fault::kDeviceNoisy;
  // compares components: the norm of a huge finite vector is infinite
  const auto largest = [](const Vec3& a) {
    return std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  };
  // a device without motors drops what they would have given
  const bool is_huge = (limits.max_force > 0 && largest(input.F_B.f) > kHuge * limits.max_force) ||
                       (limits.max_torque > 0 && largest(input.F_B.t) > kHuge * limits.max_torque);
  return is_huge ? Fault::kForceHuge : Fault::kNone;
}

/// A fault stays until it is cleared while the handle is slow.
void clear_fault(SafetyState& state, const SafetyInput& input, bool is_calm) {
  if (input.fault_clears <= state.fault_clears) return;
  if (state.fault != Fault::kNone && !is_calm) return;
  state.fault_clears = input.fault_clears;
  state.fault = Fault::kNone;
  // samples from during the fault are not compared with later ones
  state.sample.known = false;
}

/// The reasons to close the force this tick, as flags; zero if there are none.
uint32_t closed_by(const SafetyState& state, const SafetyInput& input) {
  uint32_t flags = 0;
  if (!input.armed) flags |= kServoDisarmed;
  if (state.too_fast) flags |= kServoTooFast;
  if (flags != 0 || input.force_closed) flags |= kServoSoftStart;
  return flags;
}

/// The hand feels nothing now: growth and passivity start from zero.
void forget_held(SafetyState& state) {
  state.held_B = state.rendered_B = {};
  state.passivity = {};
}

/// Zero wrench this tick, then a soft start.
SafetyOutput hold_nothing(SafetyState& state, uint32_t flags, bool jumped, double dt) {
  forget_held(state);
  state.gain = 0;
  state.heat = heated(state.heat, {}, dt);
  return {{}, flags, true, jumped, {}};
}

/// Spring against a displacement, which begins at `edge` and saturates `width` beyond it.
Vec3 edge_spring(const Vec3& out, double edge, double width, double most) {
  if (edge <= 0) return {};
  const double beyond = norm(out) - edge;
  if (beyond <= 0) return {};
  return -kEdgeShare * most * std::min(beyond / width, 1.0) * normalized(out);
}

/// Rate at which a torque may grow by itself [N·m/s].
double torque_slew(const SafetyLimits& limits) {
  if (limits.torque_slew > 0) return limits.torque_slew;
  return limits.max_force > 0 ? limits.slew * limits.max_torque / limits.max_force : 0;
}

/// Lowers the gain for a wrench of that size, which may be larger than what is saturated: neither
/// part falls faster than it may grow.
void let_go(const SafetyLimits& limits, SafetyState& state, const Wrench& F_B, double dt) {
  const double force = norm(F_B.f), torque = limits.max_torque > 0 ? norm(F_B.t) : 0;
  double rate = 1 / kLetGoTime;
  if (force > 0) rate = std::min(rate, limits.slew / force);
  if (torque > 0) rate = std::min(rate, torque_slew(limits) / torque);
  state.gain = std::max(state.gain - dt * rate, 0.0);
}

double sustained(double peak, double continuous, double heat) {
  if (continuous <= 0 || continuous >= peak) return peak;
  const double budget = continuous * continuous;
  const double left = std::clamp((budget - heat) / (kThermalBand * budget), 0.0, 1.0);
  return continuous + left * (peak - continuous);
}

/// A part of a wrench as a mixture of what was held and what is wanted.
struct Mixture {
  double held = 0, wanted = 1;  // shares

  Vec3 of(const Vec3& before, const Vec3& now) const { return held * before + wanted * now; }
};

/// Shortens a wanted vector, which may end at most `growth` away from the segment between zero
/// and `held`: so its growth along, across and against it is bounded, and it may shrink at once.
/// One farther away is moved straight towards the nearest point of the segment. A wall at rest
/// never reaches the limit: it pushes with k·(P(x) − x), P the projection onto the free space;
/// where that is convex, a motion Δx of the hand changes the force by k·|Δx| at most.
Mixture drawn_within(const Vec3& held, double growth, const Vec3& wanted) {
  const double squared = norm_squared(held);
  const double share = squared > 0 ? std::clamp(dot(wanted, held) / squared, 0.0, 1.0) : 0;
  const double beyond = norm(wanted - share * held);
  if (beyond <= growth) return {};
  const double kept = growth / beyond;
  return {(1 - kept) * share, kept};
}

/// A wrench on its way to the device, and the part of it that contacts and grasp have made.
struct Limited {
  Wrench F_B, rendered_B;

  void scale(double gain) {
    F_B = gain * F_B;
    rendered_B = gain * rendered_B;
  }
  bool saturate(const WrenchLimit& limit) {
    const Wrench before_B = F_B;
    if (!haptic::saturate(F_B, limit)) return false;
    rendered_B.f *= share_left(before_B.f, F_B.f);
    rendered_B.t *= share_left(before_B.t, F_B.t);
    return true;
  }
  /// Limits the growth from the wrench held over the last tick. The torque is scaled with its
  /// force, then limited in the same way. Returns whether it did.
  bool limit_slew(const SafetyState& state, const WrenchLimit& growth) {
    const Wrench& held_B = state.held_B;
    HAPTIC_ASSERT(growth.force >= 0 && growth.torque >= 0);
    HAPTIC_ASSERT(is_finite(held_B) && is_finite(F_B));
    const Mixture force = drawn_within(held_B.f, growth.force, F_B.f);
    const bool is_cut = force.wanted < 1;
    const double with_force = is_cut ? norm(force.of(held_B.f, F_B.f)) / norm(F_B.f) : 1;
    Mixture torque = drawn_within(held_B.t, growth.torque, with_force * F_B.t);
    const bool is_torque_cut = torque.wanted < 1;
    torque.wanted *= with_force;
    F_B = {force.of(held_B.f, F_B.f), torque.of(held_B.t, F_B.t)};
    const Wrench& before_B = state.rendered_B;
    rendered_B = {force.of(before_B.f, rendered_B.f), torque.of(before_B.t, rendered_B.t)};
    return is_cut || is_torque_cut;
  }

 private:
  static double share_left(const Vec3& before, const Vec3& after) {
    const double length = norm(before);
    return length > 0 ? norm(after) / length : 1;
  }
};

/// The edge of the workspace, and the soft start of all.
void begin_softly(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                  double dt, Limited& limited, SafetyOutput& out) {
  if (input.restart) state.gain = 0;
  if (limits.soft_start <= 0 && !input.letting_go) state.gain = 1;
  const Pose& X_BH = input.device.X_BH;
  const Vec3 turn_B = to_rotation_vector(X_BH.q * conjugate(limits.workspace_rest_B));
  const Wrench edge_B{edge_spring(X_BH.p - limits.workspace_centre_B, limits.workspace_radius,
                                  kEdgeWidth, limits.max_force),
                      edge_spring(turn_B, limits.workspace_turn, kEdgeAngle, limits.max_torque)};
  if (edge_B != Wrench{}) out.flags |= kServoWorkspaceEdge;
  limited.F_B = limited.F_B + edge_B;
  if (input.letting_go) let_go(limits, state, limited.F_B, dt);
  if (state.gain < 1) {
    out.flags |= kServoSoftStart;
    limited.scale(state.gain);
    if (!input.letting_go) state.gain = std::min(1.0, state.gain + dt / limits.soft_start);
  }
}

/// Shortens the wrench to the most that the motors can give. A torque that is dropped is flagged
/// only in ticks in which it would have been felt.
void limit_size(const SafetyLimits& limits, const WrenchLimit& bearable, Limited& limited,
                SafetyOutput& out) {
  if (limits.max_force <= 0) limited.F_B.f = limited.rendered_B.f = {};
  if (limits.max_torque <= 0) {
    if (limited.F_B.t != Vec3{}) out.flags |= kServoTorqueDropped;
    limited.F_B.t = limited.rendered_B.t = {};
  }
  const bool is_hot = bearable.force < limits.max_force || bearable.torque < limits.max_torque;
  if (is_hot) out.flags |= kServoThermal;
  if (limited.saturate(bearable)) out.flags |= kServoSaturated;
}

/// Growth that is allowed: slew over the time since the last tick, which is at most dt (after a
/// late tick the next one follows sooner), and the coupling's stiffness times the motion of the
/// handle. A force at the tool makes a torque at the handle, so the torque may also grow by the
/// lever times the force's growth.
WrenchLimit most_growth(const SafetyLimits& limits, const HandleStiffness& stiffness,
                        const HandleStep& step, double since) {
  WrenchLimit most;
  most.force =
      limits.slew * since + stiffness.translational * step.way + stiffness.turning * step.turn;
  most.torque =
      stiffness.lever * most.force + stiffness.rotational * step.turn + torque_slew(limits) * since;
  return most;
}

/// Growth and passivity of the wrench that will be held.
void limit_change(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                  const WrenchLimit& bearable, const WrenchLimit& growth, double dt,
                  Limited& limited, SafetyOutput& out) {
  if (limited.limit_slew(state, growth)) out.flags |= kServoSlewing;
  if ((input.device.flags & (kDeviceOpenLoop | kDeviceAdmittance)) != 0) return;
  PassivityInput port{input.device.X_BH, input.device.t_ns, input.surface_B, limited.F_B};
  if (!input.fading) {
    port.max_damping = limits.max_damping;
    port.max_rotational_damping = limits.max_rotational_damping;
  }
  const PassivityOutput passive = keep_passive(state.passivity, port, dt);
  if (passive.damped) out.flags |= kServoPassivity;
  limited.F_B = passive.F_B;
  limited.saturate(bearable);
  if (passive.damped) limited.limit_slew(state, growth);
  note_held(state.passivity, limited.F_B, dt);
}

/// The share of one part of the rendered wrench that is left of it, along its direction.
double share_along(const Vec3& left, const Vec3& rendered, double otherwise) {
  const double squared = norm_squared(rendered);
  return squared > 0 ? std::clamp(dot(left, rendered) / squared, 0.0, 1.0) : otherwise;
}

/// One part of the port: force and velocity, or torque and angular velocity.
struct Part {
  Vec3 wanted, held, velocity;
  double max_damping = 0;
  double still = 0;  // speed below which it does not damp

  /// The direction to push along: on the way out the last push gives the direction, because a
  /// buzzing wall releases most of its energy there.
  const Vec3& push() const { return wanted != Vec3{} ? wanted : held; }
};

/// Share of a deficit that turning has made: of what is missing in both ledgers.
double share_of_turning(double moving, double turning) {
  const double missing = std::max(-moving, 0.0), turning_missing = std::max(-turning, 0.0);
  return turning_missing > 0 ? turning_missing / (missing + turning_missing) : 0;
}

/// A debt is bounded; what is forgiven is forgiven where it arose.
void bound_debt(PassivityState& state) {
  if (state.energy >= -kPassivityDebt) return;
  const double share = share_of_turning(state.energy - state.turning, state.turning);
  state.turning += share * (-kPassivityDebt - state.energy);
  state.energy = -kPassivityDebt;
}

/// In free space a surplus is dropped and a deficit decays; a surplus of one part that the other
/// has used up is gone as well.
void forget(PassivityState& state, double dt) {
  const double left = 1 - std::min(dt / kForgetTime, 1.0);
  const double deficit = std::min(state.energy, 0.0);
  state.turning = std::clamp(state.turning, deficit, 0.0) * left;
  state.energy = deficit * left;
}

/// Subtracts the work of the held wrench since the last sample. Returns the velocity of the handle
/// relative to the surface.
Twist observe(PassivityState& state, const PassivityInput& input, const Wrench& held_B, double dt) {
  const double since = 1e-9 * static_cast<double>(input.t_ns - state.t_ns);
  const Vec3 step_B = input.X_BH.p - state.X_BH.p - since * input.surface_B.v;
  const Vec3 turn_B =
      to_rotation_vector(input.X_BH.q * conjugate(state.X_BH.q)) - since * input.surface_B.w;
  const double turning = dot(held_B.t, turn_B);
  state.energy -= dot(held_B.f, step_B) + turning;
  state.turning -= turning;
  bound_debt(state);
  state.X_BH = input.X_BH;
  state.t_ns = input.t_ns;
  state.impulse_B = {};
  state.held = 0;
  // time stamps closer than a tick would give a wrong speed
  const double time = std::max(since, dt);
  return {step_B / time, turn_B / time};
}

/// The damper that dissipates a deficit in the coming tick, along the push only, so a smooth wall
/// stays smooth. It never pulls harder than was pushed.
Vec3 damper(const Part& part, double deficit, double dt) {
  const double push = norm(part.push());
  if (!(deficit > 0) || push == 0) return {};
  const Vec3 along = part.push() / push;
  const double speed = dot(part.velocity, along);
  if (std::fabs(speed) < part.still) return {};
  const double alpha = std::min(deficit / (dt * speed * speed), part.max_damping);
  const double most = std::max(push, norm(part.held));
  return std::min(alpha * speed, most) * along;
}

}  // namespace

bool saturate(Vec3& a, double limit) {
  const double length = norm(a);
  if (length <= limit) return false;
  // scaled down first: a huge but finite vector has an infinite norm
  const double largest = std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  a = limit * kBelow * normalized(a / largest);
  return true;
}

bool saturate(Wrench& F, const WrenchLimit& limit) {
  const bool force_cut = saturate(F.f, limit.force);
  const bool torque_cut = saturate(F.t, limit.torque);
  return force_cut || torque_cut;
}

MotorHeat heated(const MotorHeat& heat, const Wrench& F_B, double dt) {
  const double share = dt / kThermalTime;
  return {heat.force + share * (norm_squared(F_B.f) - heat.force),
          heat.torque + share * (norm_squared(F_B.t) - heat.torque)};
}

WrenchLimit bearable(const SafetyLimits& limits, const MotorHeat& heat) {
  return {sustained(limits.max_force, limits.continuous_force, heat.force),
          sustained(limits.max_torque, limits.continuous_torque, heat.torque)};
}

PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt) {
  HAPTIC_ASSERT(dt > 0 && input.max_damping >= 0 && input.max_rotational_damping >= 0);
  HAPTIC_ASSERT(is_finite(input.F_B));
  PassivityOutput out{input.F_B};
  if (!state.known) {
    state.X_BH = input.X_BH;
    state.t_ns = input.t_ns;
    state.known = true;
    return out;
  }
  // without a new sample the work of the wrench is unknown
  if (input.t_ns <= state.t_ns) return out;
  const Wrench held_B = state.held > 0
                            ? Wrench{state.impulse_B.f / state.held, state.impulse_B.t / state.held}
                            : Wrench{};
  const Twist V_B = observe(state, input, held_B, dt);
  const Part moving{input.F_B.f, held_B.f, V_B.v, input.max_damping, kStill};
  const Part turning{input.F_B.t, held_B.t, V_B.w, input.max_rotational_damping, kStillTurning};
  if (moving.push() == Vec3{} && turning.push() == Vec3{}) {
    forget(state, dt);
    return out;
  }

  // energy after the coming tick, if the handle keeps its velocity
  const double work = dt * dot(moving.wanted, moving.velocity);
  const double turning_work = dt * dot(turning.wanted, turning.velocity);
  const double expected = state.energy - (work + turning_work);
  if (expected >= -kPassivitySlack) return out;
  const double deficit = -kPassivitySlack - expected;
  const double share =
      share_of_turning(state.energy - state.turning - work, state.turning - turning_work);
  const Vec3 brake_B = damper(moving, (1 - share) * deficit, dt);
  const Vec3 turning_brake_B = damper(turning, share * deficit, dt);
  out.damped = brake_B != Vec3{} || turning_brake_B != Vec3{};
  out.F_B = {input.F_B.f - brake_B, input.F_B.t - turning_brake_B};
  return out;
}

void note_held(PassivityState& state, const Wrench& held_B, double dt) {
  HAPTIC_ASSERT(dt > 0 && is_finite(held_B));
  state.impulse_B = state.impulse_B + dt * held_B;
  state.held += dt;
}

SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt) {
  HAPTIC_ASSERT(dt > 0);
  HAPTIC_ASSERT(limits.max_force >= 0 && limits.max_torque >= 0);
  HAPTIC_ASSERT(limits.slew >= 0 && limits.torque_slew >= 0);
  HAPTIC_ASSERT(limits.velocity_limit > 0 && limits.angular_velocity_limit > 0);
  HAPTIC_ASSERT(state.gain >= 0 && state.gain <= 1);
  HAPTIC_ASSERT(input.now_ns >= input.device.t_ns);
  const Twist& V_BH = input.device.V_BH;
  const double speed = norm(V_BH.v);
  const double spin = is_turning_felt(limits, input.stiffness) ? norm(V_BH.w) : 0;
  const bool is_calm = speed < kCalm && spin < kCalmTurning;
  const double passed = static_cast<double>(input.now_ns - state.woke_ns) / 1e9;
  state.woke_ns = input.now_ns;
  clear_fault(state, input, is_calm);
  const HandleStep step =
      input.device_finite ? follow_handle(limits, state.sample, input) : HandleStep{};
  const Fault fault = find_fault(limits, step, input);
  if (state.fault == Fault::kNone) state.fault = fault;
  if (state.fault != Fault::kNone) return hold_nothing(state, kServoFault, step.jumped, dt);
  if (speed > limits.velocity_limit || spin > limits.angular_velocity_limit) state.too_fast = true;
  if (is_calm) state.too_fast = false;
  const uint32_t closed = closed_by(state, input);
  if (closed != 0) return hold_nothing(state, closed, step.jumped, dt);

  SafetyOutput out;
  Limited limited{input.F_B, input.F_B};
  if (input.released) forget_held(state);
  begin_softly(limits, state, input, dt, limited, out);
  const WrenchLimit most = bearable(limits, state.heat);
  limit_size(limits, most, limited, out);
  const double since = passed > 0 ? std::min(passed, dt) : dt;
  const WrenchLimit growth = most_growth(limits, input.stiffness, step, since);
  limit_change(limits, state, input, most, growth, dt, limited, out);
  out.F_B = state.held_B = limited.F_B;
  state.rendered_B = limited.rendered_B;
  // what objects push against each other through the tool is felt as much as all of it
  const double gain = limits.max_force > 0 ? state.gain : 0;
  out.felt.force = share_along(limited.rendered_B.f, input.F_B.f, gain);
  out.felt.torque =
      share_along(limited.rendered_B.t, input.F_B.t, limits.max_torque > 0 ? out.felt.force : 0);
  state.heat = heated(state.heat, out.F_B, dt);
  return out;
}

}  // namespace haptic
