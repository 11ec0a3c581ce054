// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/config/config.h"
#include "proto/wire/wire.h"
#include "servo/safety/handle_motion.h"
#include "servo/safety/limits.h"
#include "servo/safety/passivity.h"

namespace haptic {

struct SafetyState {
  double gain = 0;  // of the soft start, 0 to 1
  Fault fault = Fault::kNone;
  uint64_t fault_clears = 0;  // number of the clear request carried out last
  bool too_fast = false;      // true until the handle has slowed down
  MotorHeat heat;
  Wrench held_B;        // wrench held over the last tick
  Wrench rendered_B;    // the part of it that contacts and grasp have made
  int64_t woke_ns = 0;  // wake-up of the last tick
  LastSample sample;
  bool jumped = false;  // this sample is farther than the hand can have moved
  PassivityState passivity;
};

struct SafetyInput {
  Wrench F_B;                  // wanted by the solver, or measured of the hand; at the handle, in B
  HandleStiffness stiffness;   // of the coupling in force
  DeviceState device{};        // this tick's sample
  int64_t now_ns = 0;          // of the wake-up; never before the sample's own instant
  bool device_finite = true;   // no NaN or infinity in the sample
  bool device_follows = true;  // an admittance device is where it was commanded to be
  bool contacts_finite = true;  // none in the contacts and the poses of the objects
  bool armed = true;            // by the dead-man button or `hapt arm`
  bool force_closed = false;    // clutch held, paused or no free proxy pose: zero, then soft start
  bool restart = false;         // the proxy was placed anew: soft start from the present pose
  bool letting_go = false;      // the solver changes: the gain of the soft start falls to zero
  bool released = false;        // the device may have been set to zero since the last tick
  bool fading = false;          // contacts are too old: the force fades or is gone
  Vec3 surface_velocity_B;      // of the touched surface at the handle, in device units [m/s]
  Vec3 surface_turning_B;       // its angular velocity [rad/s]
  uint64_t fault_clears = 0;    // of the ControlFrame in force
};

/// How much of the rendered force and torque the hand feels, 0 to 1: what is rendered pushes the
/// objects by as much, sign reversed. The edge of the workspace and the passivity damper push
/// nothing, and a torque that the device drops turns nothing.
struct FeltShare {
  double force = 0, torque = 0;
};

struct SafetyOutput {
  Wrench F_B;
  uint32_t flags = 0;   // ServoFlag
  bool closed = false;  // nothing may be rendered: by a fault, or one of step 2
  FeltShare felt;
};

/// The last stages before the device; they run after every solver and cannot be switched off. All
/// that shapes a force on its way from the contacts to the motors, in order, with what each bounds
/// and why it is not one with its neighbour. A and B are before safety, C after it; what holds for
/// force and moving holds for torque and turning, each with its own limits.
///
/// A. Age of the contacts (contact_age.h): what old contacts may still push, by a weight. It knows
///    the contacts, and safety only a wrench.
/// B. Step of the felt force (servo/render/felt_step.h), for bodies: how far an answer of contact
///    may move the force apart from the hand's own motion, seen from the object that carries it.
///    Safety does not know objects; here forces may also fall no faster.
/// 1. Faults: a value that is not finite, a force or torque over 1000 times the limit, a pose that
///    jumps (handle_motion.h), or a device whose driver reports stale or noisy answers. A fault
///    latches: zero wrench until ControlFrame::fault_clears asks for it and the handle is calm,
///    slower than 0.1 m/s and 1 rad/s; then soft start.
/// 2. Closed (not armed, clutch, pause, no free pose, or faster than a velocity limit and not yet
///    calm again): zero wrench, then soft start. It ends by itself, a fault does not.
/// 3. Soft edge of the workspace (edge_wrench in limits.h), which bounds where the handle goes;
/// then
///    the gain of the soft start, which bounds edge and contacts together. While the solver is
///    about to change, that gain falls to zero instead, within 50 ms and no faster than the slews.
/// 4. Saturation, direction kept, at what the motors can sustain (sustainable in limits.h):
/// max_force
///    and max_torque, less while |F|² low-passed over 10 s is near the continuous rating.
/// 5. Slew (slew.h), whatever contact says: growth by at most slew·dt + k·|motion of the handle
/// since
///    its last sample|, k the coupling's stiffness; after a late tick dt is the time that has
///    passed since. A wall at rest asks for no more at any speed of the hand, so it is never
///    slowed. The wrench shrinks at once. It comes after 4: a force that wants to be huge is slewed
///    from the limit on.
/// 6. Passivity observer and controller on the wrench that is held (passivity.h), which bounds the
///    energy given to the hand: only this wrench is what the hand gets. Not for an open-loop
///    device, where it moves nothing; without damping while contacts fade or are stale, where the
///    wanted wrench is already the most that may remain. That of an admittance device acts on the
///    body that the wrench moves (servo/admittance/energy_ledger.h).
/// 7. Saturation and slew again, of the sum with the damping of 6.
/// C. Clamp of the motors' currents, in each driver: it alone knows the linkage.
SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt);

}  // namespace haptic
