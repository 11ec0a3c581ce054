// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/config/config.h"
#include "proto/wire/wire.h"
#include "servo/safety/passivity.h"

namespace haptic {

/// What the hand may feel at most, in device units: the smaller of what the device can do and what
/// the config allows.
struct SafetyLimits {
  double max_force = 0;         // [N]
  double max_torque = 0;        // [N·m]; 0: the torque is dropped, and said
  double soft_start = 0.5;      // ramp from zero to full force [s]
  double continuous_force = 0;  // what the motors bear for ever [N]; 0: as much as max_force
  double slew = 2000;           // of a force that grows by itself, not by the hand's motion [N/s]
  double velocity_limit = 2;    // of the handle [m/s]
  Vec3 workspace_centre_B{};    // [m]
  double workspace_radius = 0;  // a soft edge pushes back beyond it [m]; 0: none
  double max_damping = 2;       // of the passivity controller [N·s/m]
};

struct SafetyState {
  double gain = 0;  // soft start
  Fault fault = Fault::kNone;
  uint64_t fault_clears = 0;  // of the request that was last carried out
  bool too_fast = false;      // until the handle has slowed down
  double heat = 0;            // low-passed |F|² [N²]
  Wrench held_B;              // over the last tick
  int64_t woke_ns = 0;        // of the last tick
  Pose X_BH;                  // last fresh sample
  int64_t measured_ns = 0;    // and when it was true
  bool any_sample = false;
  bool jumped = false;  // this tick's sample is further than the hand can have moved
  PassivityState passivity;
};

/// What the handle feels at most per way and turn of its own: the coupling's stiffness in device
/// units, where nothing else moves.
struct HandleStiffness {
  double translational = 0;  // [N/m]
  double turning = 0;        // of the force, where the tool is off the handle [N/rad]
  double rotational = 0;     // [N·m/rad]
  double lever = 0;          // from the handle to the tool: of the force's torque [m]
};

struct SafetyInput {
  Wrench F_B;                   // what the solver asks for, on the handle, in B
  HandleStiffness stiffness;    // of the coupling in force
  DeviceState device{};         // this tick's sample
  int64_t now_ns = 0;           // of the wake-up; never before the sample's own instant
  bool device_finite = true;    // it held no NaN or infinity
  bool contacts_finite = true;  // nor did the contacts and the poses of the objects
  bool armed = true;            // by the dead-man button or `hapt arm`
  bool force_closed = false;    // clutch held, paused or no free proxy pose: zero, then soft start
  bool restart = false;         // the proxy was placed anew: soft start from the present pose
  bool released = false;        // somebody may have put the device to zero since the last tick
  bool fading = false;          // contacts are too old: the force fades, or is gone
  Vec3 surface_velocity_B;      // of what is touched, in device units [m/s]
  uint64_t fault_clears = 0;    // of the ControlFrame in force
};

struct SafetyOutput {
  Wrench F_B;
  uint32_t flags = 0;  // ServoFlag
};

/// The last stage before the device; runs after every solver and cannot be switched off. In this
/// order:
///  1. finite check; a force a thousand times the limit, a pose that jumps further than twice
///     the velocity limit explains over the time since the sample before, or a device whose driver
///     says that its answers are stale or noisy: latched fault, zero wrench. Cleared by
///     ControlFrame::fault_clears, once the handle is slower than 0.1 m/s; then soft start.
///  2. closed (not armed, clutch, pause, no free pose, faster than the velocity limit and not yet
///     slower than 0.1 m/s again): zero wrench, then soft start.
///  3. the soft edge of the workspace: a spring inwards, at most 30 % of max_force; through the
///     soft start like the rest.
///  4. saturation, direction kept.
///  5. thermal budget: |F|² low-passed over 10 s; as it comes within a fifth of continuous_force²,
///     the limit goes from max_force to continuous_force.
///  6. growth (force_growth.h): whatever contact says, the force grows by at most
///     slew·dt + k·|motion of the handle since its last sample|, k the coupling's stiffness; a tick
///     that follows a late one counts for the time that has passed. A wall at rest asks for no more
///     than that, at any speed of the hand, so it is never slowed. What is held shrinks at once.
///  7. passivity observer and controller, on the force that is really held (passivity.h); not for
///     an open-loop device, where the force moves nothing, and not while contacts fade or are
///     stale: what is asked for then is the most that may be left.
///  8. growth and saturation of the sum.
/// The fade of stale contacts is in weigh_contacts, before it; the motors' clamp in the driver.
SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt);

}  // namespace haptic
