// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/safety.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "servo/safety/slew.h"

namespace haptic {
namespace {

constexpr double kHuge = 1000;       // times the limit: no wall pushes that hard
constexpr double kLetGoTime = 0.05;  // in which a force is let go, as that of old contacts [s]

Fault find_fault(const SafetyLimits& limits, const SafetyState& state, const SafetyInput& input) {
  if (!input.device_finite) return Fault::kDeviceNotFinite;
  if (!input.contacts_finite) return Fault::kContactsNotFinite;
  if (!is_finite(input.F_B)) return Fault::kForceNotFinite;
  if (state.jumped) return Fault::kPoseJump;
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
void clear_fault(SafetyState& state, const SafetyInput& input, const HandleSpeed& speed) {
  if (input.fault_clears <= state.fault_clears) return;
  if (state.fault != Fault::kNone && !is_calm(speed)) return;
  state.fault_clears = input.fault_clears;
  state.fault = Fault::kNone;
  // samples from during the fault are not compared with later ones
  state.sample.known = false;
}

/// Time since the last tick, at most dt: after a late tick the next one follows sooner [s].
double since_last(SafetyState& state, const SafetyInput& input, double dt) {
  const double since = static_cast<double>(input.now_ns - state.woke_ns) / 1e9;
  state.woke_ns = input.now_ns;
  return since > 0 ? std::min(since, dt) : dt;
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

/// The hand feels nothing now: growth and passivity start from zero.
void forget_held(SafetyState& state) {
  state.held_B = state.rendered_B = {};
  state.passivity = {};
}

/// Zero wrench this tick, then a soft start.
SafetyOutput hold_nothing(SafetyState& state, uint32_t flags, double dt) {
  forget_held(state);
  state.gain = 0;
  state.heat = heated(state.heat, {}, dt);
  return {{}, flags, true, {}};
}

/// The reasons to close the force this tick, as flags; zero if there are none.
uint32_t closed_by(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                   const HandleSpeed& speed) {
  if (is_too_fast(limits, speed)) state.too_fast = true;
  if (is_calm(speed)) state.too_fast = false;
  uint32_t flags = 0;
  if (!input.armed) flags |= kServoDisarmed;
  if (state.too_fast) flags |= kServoTooFast;
  if (flags != 0 || input.force_closed) flags |= kServoSoftStart;
  return flags;
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
  bool limit_slew(const SafetyState& held, const WrenchGrowth& growth) {
    const SlewLimit limit = haptic::limit_slew(held.held_B, growth, F_B);
    F_B = limit.of(held.held_B, F_B);
    rendered_B = limit.of(held.rendered_B, rendered_B);
    return limit.cut;
  }

 private:
  static double share_left(const Vec3& before, const Vec3& after) {
    const double length = norm(before);
    return length > 0 ? norm(after) / length : 1;
  }
};

/// The share of one part of the rendered wrench that is left of it, along its direction.
double share_along(const Vec3& left, const Vec3& rendered, double otherwise) {
  const double squared = norm_squared(rendered);
  return squared > 0 ? std::clamp(dot(left, rendered) / squared, 0.0, 1.0) : otherwise;
}

/// The edge of the workspace, and the soft start of all.
void begin_softly(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                  double dt, Limited& limited, SafetyOutput& out) {
  if (input.restart) state.gain = 0;
  if (limits.soft_start <= 0 && !input.letting_go) state.gain = 1;
  const Wrench edge_B = edge_wrench(limits, input.device.X_BH);
  if (edge_B != Wrench{}) out.flags |= kServoWorkspaceEdge;
  limited.F_B = limited.F_B + edge_B;
  if (input.letting_go) let_go(limits, state, limited.F_B, dt);
  if (state.gain < 1) {
    out.flags |= kServoSoftStart;
    limited.scale(state.gain);
    if (!input.letting_go) state.gain = std::min(1.0, state.gain + dt / limits.soft_start);
  }
}

/// What the motors can give at most. A torque that is dropped is flagged only in ticks in which it
/// would have been felt.
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

/// Growth and passivity of the wrench that will be held.
void limit_change(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                  const WrenchLimit& bearable, const WrenchGrowth& growth, double dt,
                  Limited& limited, SafetyOutput& out) {
  if (limited.limit_slew(state, growth)) out.flags |= kServoSlewing;
  if ((input.device.flags & (kDeviceOpenLoop | kDeviceAdmittance)) != 0) return;
  PassivityInput port{input.device.X_BH,
                      input.device.t_ns,
                      {input.surface_velocity_B, input.surface_turning_B},
                      limited.F_B};
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

}  // namespace

SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt) {
  HAPTIC_ASSERT(dt > 0);
  HAPTIC_ASSERT(limits.max_force >= 0 && limits.max_torque >= 0);
  HAPTIC_ASSERT(limits.slew >= 0 && limits.torque_slew >= 0);
  HAPTIC_ASSERT(limits.velocity_limit > 0 && limits.angular_velocity_limit > 0);
  HAPTIC_ASSERT(state.gain >= 0 && state.gain <= 1);
  HAPTIC_ASSERT(input.now_ns >= input.device.t_ns);
  const HandleSpeed speed = speed_of(limits, input.stiffness, input.device.V_BH);
  const double since = since_last(state, input, dt);
  clear_fault(state, input, speed);
  HandleStep step;
  if (input.device_finite) {
    step = follow_handle(limits, input.stiffness, state.sample, input.device, input.now_ns);
  }
  state.jumped = step.jumped;
  const Fault fault = find_fault(limits, state, input);
  if (state.fault == Fault::kNone) state.fault = fault;
  if (state.fault != Fault::kNone) return hold_nothing(state, kServoFault, dt);
  const uint32_t closed = closed_by(limits, state, input, speed);
  if (closed != 0) return hold_nothing(state, closed, dt);

  SafetyOutput out;
  Limited limited{input.F_B, input.F_B};
  if (input.released) forget_held(state);
  begin_softly(limits, state, input, dt, limited, out);
  const WrenchLimit bearable = sustainable(limits, state.heat);
  limit_size(limits, bearable, limited, out);
  const WrenchGrowth growth = most_growth(limits, input.stiffness, step.motion, since);
  limit_change(limits, state, input, bearable, growth, dt, limited, out);
  out.F_B = limited.F_B;
  // what objects push against each other through the tool is felt as much as all of it
  const double gain = limits.max_force > 0 ? state.gain : 0;
  out.felt.force = share_along(limited.rendered_B.f, input.F_B.f, gain);
  out.felt.torque =
      share_along(limited.rendered_B.t, input.F_B.t, limits.max_torque > 0 ? out.felt.force : 0);
  state.held_B = limited.F_B;
  state.rendered_B = limited.rendered_B;
  state.heat = heated(state.heat, out.F_B, dt);
  return out;
}

}  // namespace haptic
