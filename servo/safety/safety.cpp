// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/safety.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "servo/safety/force_growth.h"

namespace haptic {
namespace {

constexpr double kHuge = 1000;          // times the limit: no wall pushes that hard
constexpr double kJumpSpeed = 2;        // times the velocity limit
constexpr double kJumpMargin = 2e-3;    // encoder steps and jitter of the time stamps [m]
constexpr double kCalm = 0.1;           // slow enough to start again [m/s]
constexpr double kThermalTime = 10;     // time constant of the thermal low-pass [s]
constexpr double kThermalBand = 0.2;    // last part of the budget, over which the limit falls
constexpr double kEdgeShare = 0.3;      // largest force of the workspace edge over max_force
constexpr double kEdgeWidth = 5e-3;     // way over which the edge's spring reaches that [m]
constexpr double kLetGoTime = 0.05;     // in which a force is let go, as that of old contacts [s]
constexpr double kBelow = 1 - 0x1p-50;  // slightly less than 1: rounding must not exceed a limit

/// Shortens a vector to the limit, direction kept. A limit of zero leaves nothing.
bool saturate(Vec3& a, double limit) {
  const double length = norm(a);
  if (length <= limit) return false;
  // scaled down first: a huge but finite vector has an infinite norm
  const double largest = std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  a = limit * kBelow * normalized(a / largest);
  return true;
}

/// Motion of the handle between the last two fresh samples; zero if this tick's is not fresh.
struct HandleMotion {
  double way = 0;   // translation [m]
  double turn = 0;  // rotation [rad]
};

/// Sets state.jumped if the handle moved farther than it can have in that time.
HandleMotion follow_handle(const SafetyLimits& limits, SafetyState& state,
                           const SafetyInput& input) {
  const DeviceState& device = input.device;
  state.jumped = false;
  if (!input.device_finite) return {};
  // homing, and a device that comes back, legitimately move the pose
  const bool known = (device.flags & kDeviceHomed) != 0 && (device.flags & kDeviceLost) == 0;
  if (!known) state.any_sample = false;
  if (!known || (device.flags & kDeviceFresh) == 0) return {};
  HandleMotion motion;
  if (state.any_sample) {
    motion.way = norm(device.X_BH.p - state.X_BH.p);
    motion.turn = norm(to_rotation_vector(device.X_BH.q * conjugate(state.X_BH.q)));
    // up to now, since a late sample may be of any instant in between
    const double since = static_cast<double>(input.now_ns - state.measured_ns) * 1e-9;
    state.jumped =
        motion.way > kJumpMargin + kJumpSpeed * limits.velocity_limit * std::max(since, 0.0);
  }
  state.X_BH = device.X_BH;
  state.measured_ns = device.t_ns;
  state.any_sample = true;
  return motion;
}

Fault find_fault(const SafetyLimits& limits, const SafetyState& state, const SafetyInput& input) {
  if (!input.device_finite) return Fault::kDeviceNotFinite;
  if (!input.contacts_finite) return Fault::kContactsNotFinite;
  if (!is_finite(input.F_B)) return Fault::kForceNotFinite;
  if (state.jumped) return Fault::kPoseJump;
  if ((input.device.flags & kDeviceStale) != 0) return Fault::kDeviceStale;
  if ((input.device.flags & kDeviceNoisy) != 0) return Fault::kDeviceNoisy;
  // compares components: the norm of a huge finite vector is infinite
  const auto largest = [](const Vec3& a) {
    return std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  };
  // a device without torque motors drops the torque
  const bool is_huge = largest(input.F_B.f) > kHuge * limits.max_force ||
                       (limits.max_torque > 0 && largest(input.F_B.t) > kHuge * limits.max_torque);
  return is_huge ? Fault::kForceHuge : Fault::kNone;
}

/// A fault stays until it is cleared while the handle is slow.
void clear_fault(SafetyState& state, const SafetyInput& input, double speed) {
  if (input.fault_clears <= state.fault_clears) return;
  if (state.fault != Fault::kNone && !(speed < kCalm)) return;
  state.fault_clears = input.fault_clears;
  state.fault = Fault::kNone;
  // samples from during the fault are not compared with later ones
  state.any_sample = false;
}

/// Spring towards the centre that saturates kEdgeWidth beyond the edge.
Vec3 edge_force(const SafetyLimits& limits, const Vec3& p_B) {
  if (limits.workspace_radius <= 0) return {};
  const Vec3 out_B = p_B - limits.workspace_centre_B;
  const double beyond = norm(out_B) - limits.workspace_radius;
  if (beyond <= 0) return {};
  return -kEdgeShare * limits.max_force * std::min(beyond / kEdgeWidth, 1.0) * normalized(out_B);
}

/// Time since the last tick, at most dt: after a late tick the next one follows sooner [s].
double since_last(SafetyState& state, const SafetyInput& input, double dt) {
  const double since = static_cast<double>(input.now_ns - state.woke_ns) / 1e9;
  state.woke_ns = input.now_ns;
  return since > 0 ? std::min(since, dt) : dt;
}

/// Growth allowed in this tick. Torque without motion reaches its limit in the same time as force.
WrenchGrowth most_growth(const SafetyLimits& limits, const HandleStiffness& stiffness,
                         const HandleMotion& motion, double since) {
  WrenchGrowth most;
  most.force =
      limits.slew * since + stiffness.translational * motion.way + stiffness.turning * motion.turn;
  most.torque = stiffness.lever * most.force + stiffness.rotational * motion.turn;
  if (limits.max_force > 0)
    most.torque += limits.slew * since * limits.max_torque / limits.max_force;
  return most;
}

/// Force the motors can sustain at present [N].
double thermal_limit(const SafetyLimits& limits, const SafetyState& state) {
  if (limits.continuous_force <= 0 || limits.continuous_force >= limits.max_force) {
    return limits.max_force;
  }
  const double budget = limits.continuous_force * limits.continuous_force;
  const double left = std::clamp((budget - state.heat) / (kThermalBand * budget), 0.0, 1.0);
  return limits.continuous_force + left * (limits.max_force - limits.continuous_force);
}

/// Lowers the gain for a force of that size, which may be larger than what is saturated: it falls
/// no faster than it may grow.
void let_go(const SafetyLimits& limits, SafetyState& state, double force, double dt) {
  double rate = 1 / kLetGoTime;
  if (force > 0) rate = std::min(rate, limits.slew / force);
  state.gain = std::max(state.gain - dt * rate, 0.0);
}

/// The hand feels nothing now: growth and passivity start from zero.
void forget_held(SafetyState& state) {
  state.held_B = {};
  state.passivity = {};
}

/// Zero wrench this tick, then a soft start.
SafetyOutput hold_nothing(SafetyState& state, uint32_t flags, double dt) {
  forget_held(state);
  state.gain = 0;
  state.heat -= dt / kThermalTime * state.heat;
  return {{}, flags};
}

/// The reasons to close the force this tick, as flags; zero if there are none.
uint32_t closed_by(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                   double speed) {
  if (speed > limits.velocity_limit) state.too_fast = true;
  if (speed < kCalm) state.too_fast = false;
  uint32_t flags = 0;
  if (!input.armed) flags |= kServoDisarmed;
  if (state.too_fast) flags |= kServoTooFast;
  if (flags != 0 || input.force_closed) flags |= kServoSoftStart;
  return flags;
}

}  // namespace

SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt) {
  HAPTIC_ASSERT(dt > 0);
  HAPTIC_ASSERT(limits.max_force >= 0 && limits.max_torque >= 0);
  HAPTIC_ASSERT(limits.slew >= 0 && limits.velocity_limit > 0);
  HAPTIC_ASSERT(state.gain >= 0 && state.gain <= 1);
  HAPTIC_ASSERT(input.now_ns >= input.device.t_ns);
  const double speed = norm(input.device.V_BH.v);
  const double since = since_last(state, input, dt);
  clear_fault(state, input, speed);
  const HandleMotion motion = follow_handle(limits, state, input);
  const Fault fault = find_fault(limits, state, input);
  if (state.fault == Fault::kNone) state.fault = fault;
  if (state.fault != Fault::kNone) return hold_nothing(state, kServoFault, dt);
  const uint32_t closed = closed_by(limits, state, input, speed);
  if (closed != 0) return hold_nothing(state, closed, dt);

  SafetyOutput out{input.F_B, 0};
  if (input.released) forget_held(state);
  if (input.restart) state.gain = 0;
  if (limits.soft_start <= 0 && !input.letting_go) state.gain = 1;
  const Vec3 edge_B = edge_force(limits, input.device.X_BH.p);
  if (edge_B != Vec3{}) out.flags |= kServoWorkspaceEdge;
  out.F_B.f += edge_B;
  if (input.letting_go) let_go(limits, state, norm(out.F_B.f), dt);
  if (state.gain < 1) {
    out.flags |= kServoSoftStart;
    out.F_B = state.gain * out.F_B;
    if (!input.letting_go) state.gain = std::min(1.0, state.gain + dt / limits.soft_start);
  }

  // flagged only in ticks in which a torque would have been felt
  if (limits.max_torque <= 0) {
    if (out.F_B.t != Vec3{}) out.flags |= kServoTorqueDropped;
    out.F_B.t = {};
  }
  const double bearable = thermal_limit(limits, state);
  if (bearable < limits.max_force) out.flags |= kServoThermal;
  const bool force_cut = saturate(out.F_B.f, bearable);
  const bool torque_cut = saturate(out.F_B.t, limits.max_torque);
  if (force_cut || torque_cut) out.flags |= kServoSaturated;

  const WrenchGrowth growth = most_growth(limits, input.stiffness, motion, since);
  if (limit_growth(state.held_B, growth, out.F_B)) out.flags |= kServoSlewing;
  if ((input.device.flags & kDeviceOpenLoop) == 0) {
    const PassivityOutput passive =
        keep_passive(state.passivity,
                     {input.device.X_BH.p, input.device.t_ns, input.surface_velocity_B, out.F_B.f,
                      input.fading ? 0 : limits.max_damping},
                     dt);
    if (passive.damped) out.flags |= kServoPassivity;
    out.F_B.f = passive.force_B;
    saturate(out.F_B.f, bearable);
    if (passive.damped) limit_growth(state.held_B, growth, out.F_B);
    note_held(state.passivity, out.F_B.f, dt);
  }
  state.held_B = out.F_B;
  state.heat += dt / kThermalTime * (norm_squared(out.F_B.f) - state.heat);
  return out;
}

}  // namespace haptic
