// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/math/pose.h"
#include "proto/wire/wire.h"

namespace haptic {

/// By which a handle may be elsewhere than its speed allows: encoder steps and jitter of the time
/// stamps [m], [rad]; 20 mrad are 2 mm at 100 mm.
inline constexpr double kJumpWay = 2e-3, kJumpTurn = 20e-3;

/// Limits of what the hand may feel, in device units: the smaller of the device's and the config's.
struct SafetyLimits {
  double max_force = 0;          // [N]
  double max_torque = 0;         // [N·m]; 0: torque is dropped and flagged
  double soft_start = 0.5;       // ramp from zero to full force [s]
  double continuous_force = 0;   // continuous rating of the motors [N]; 0: max_force
  double continuous_torque = 0;  // the same for torque [N·m]; 0: max_torque
  double slew = 2000;            // of a force that grows without motion of the hand [N/s]
  double torque_slew = 0;        // of a torque; 0: in as long as the force to its limit [N·m/s]
  double velocity_limit = 2;     // of the handle [m/s]
  double angular_velocity_limit = 20;    // [rad/s]
  Vec3 workspace_centre_B{};             // [m]
  double workspace_radius = 0;           // a soft edge pushes back beyond it [m]; 0: none
  Quat workspace_rest_B{};               // orientation of the handle in the middle of its range
  double workspace_turn = 0;             // a soft edge turns back beyond it [rad]; 0: none
  double max_damping = 2;                // bound of the passivity controller [N·s/m]
  double max_rotational_damping = 0.01;  // the same for turning [N·m·s/rad]
};

/// Largest change of the coupling's wrench per motion of the handle, in device units, while nothing
/// else moves.
struct HandleStiffness {
  double translational = 0;  // [N/m]
  double turning = 0;        // of the force by a rotation, when the tool is off the handle [N/rad]
  double rotational = 0;     // [N·m/rad]
  double lever = 0;          // distance from handle to tool, by which the force makes a torque [m]
};

/// Largest magnitudes of a wrench.
struct WrenchLimit {
  double force = 0;   // [N]
  double torque = 0;  // [N·m]
};

/// Shortens a vector to the limit, direction kept; returns whether it did. A limit of zero leaves
/// nothing.
bool saturate(Vec3& a, double limit);
/// Both parts of a wrench.
bool saturate(Wrench& F, const WrenchLimit& limit);

/// Load of the motors: the squares of force and torque through a low-pass of 10 s.
struct MotorHeat {
  double force = 0;   // [N²]
  double torque = 0;  // [(N·m)²]
};

/// The load after `dt` seconds under F.
MotorHeat heated(const MotorHeat& heat, const Wrench& F_B, double dt);

/// The most that the motors can give with such a load.
WrenchLimit bearable(const SafetyLimits& limits, const MotorHeat& heat);

/// The last fresh sample of a device whose place is known.
struct LastSample {
  Pose X_BH;
  int64_t measured_ns = 0;  // its instant
  bool known = false;
};

/// Deficit of energy at which the controller begins to act [J]. Quantised positions and the noise
/// of a hand make a passive wall look active by less than this.
inline constexpr double kPassivitySlack = 1e-3;
/// Largest deficit that is carried over [J]: what the damper could not dissipate at once.
inline constexpr double kPassivityDebt = 50e-3;

/// Energy the hand has put into the port since contact began, minus the energy it got back [J].
struct PassivityState {
  double energy = 0;   // of force and torque together
  double turning = 0;  // the part of it that torque and turning have made
  Pose X_BH;           // handle at the last sample
  int64_t t_ns = 0;    // its instant
  Wrench impulse_B;    // of the wrench on the hand since that sample [N·s, N·m·s]
  double held = 0;     // duration of that impulse [s]
  bool known = false;  // false: no sample yet
};

struct PassivityInput {
  Pose X_BH;                          // handle at the newest sample
  int64_t t_ns = 0;                   // its instant; not later than the previous one: no new sample
  Twist surface_B;                    // of the touched surface: a moving object's work is its own
  Wrench F_B;                         // to be held over the coming tick
  double max_damping = 0;             // bound of α: what the device renders stably [N·s/m]
  double max_rotational_damping = 0;  // the same for turning [N·m·s/rad]
};

struct PassivityOutput {
  Wrench F_B;
  bool damped = false;  // the controller acted
};

/// Passivity observer and controller at the port between hand and device, in device units. At each
/// new sample, Δx is the displacement of the handle since the last one relative to the surface, Δθ
/// its rotation vector in B, Δt the time between them (at least dt), v = Δx/Δt and ω = Δθ/Δt:
///
/// observer: E −= f_held · Δx + τ_held · Δθ, with the wrench held over that time.
///
/// controller: where E − (f·v + τ·ω) dt < −slack, a damper dissipates the deficit. The deficit is
/// paid where it arose: force and torque have ledgers of their own, which sum up to E, and it is
/// divided among those that are negative in proportion. For the force, f_pc = −α v along f (or
/// along f_held, if f is zero), α = deficit / (dt v²) ≤ max_damping, and |f_pc| is at most the
/// larger of |f| and |f_held|, so the force only decays once the hand has left the wall. The torque
/// likewise, with ω and max_rotational_damping.
///
/// Pairing F_k with the step before it, x_k − x_{k−1}, would give the energy that sampling adds the
/// wrong sign: an active wall would look dissipative. In free space a surplus is dropped at once
/// and a deficit decays over half a second, so that the leaks of a wall that is tapped repeatedly
/// add up. Source: Hannaford & Ryu 2002.
PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt);

/// Notes the wrench that is held over the coming tick, after all limits.
void note_held(PassivityState& state, const Wrench& held_B, double dt);

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
  Twist surface_B;              // of the touched surface at the handle, in device units
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
  bool jumped = false;  // the sample is farther than the hand can have moved
  FeltShare felt;
};

/// The last stages before the device; they run after every solver and cannot be switched off. All
/// that shapes a force on its way from the contacts to the motors, in order, with what each bounds
/// and why it is not one with its neighbour. A and B are before safety, C after it; what holds for
/// force and moving holds for torque and turning, each with its own limits.
///
/// A. Age of the contacts (contact_age.h): what old contacts may still push, by a weight. It knows
///    the contacts, and safety only a wrench.
/// B. Step of the felt force (limit_felt_step), for bodies: how far an answer of contact may move
///    the force apart from the hand's own motion, seen from the object that carries it. Safety does
///    not know objects; here forces may also fall no faster.
/// 1. Faults: a value that is not finite, a force or torque over 1000 times the limit, a pose that
///    jumps (farther from the last fresh one than twice a velocity limit allows, plus 2 mm or
///    20 mrad), or a device whose driver reports stale or noisy answers. A fault latches: zero
///    wrench until ControlFrame::fault_clears asks for it and the handle is calm, slower than
///    0.1 m/s and 1 rad/s; then soft start.
/// 2. Closed (not armed, clutch, pause, no free pose, or faster than a velocity limit and not yet
///    calm again): zero wrench, then soft start. It ends by itself, a fault does not. Where neither
///    torque is rendered nor the tool lies off the handle, turning changes nothing that is felt,
///    and no limit holds for it.
/// 3. Soft edge of the workspace, which bounds where the handle goes: a spring towards the centre,
///    from workspace_radius on, which reaches 30 % of max_force 5 mm beyond; likewise one towards
///    the rest orientation within 0.05 rad. Then the gain of the soft start, which bounds edge and
///    contacts together. While the solver is about to change, that gain falls to zero instead,
///    within 50 ms and no faster than the slews.
/// 4. Saturation, direction kept, at what the motors can sustain: max_force and max_torque, and
///    over the last fifth below the square of the continuous rating less and less, down to that
///    rating, by the load of each (MotorHeat).
/// 5. Slew, whatever contact says: growth by at most slew·dt + k·|motion of the handle since its
///    last sample|, k the coupling's stiffness; after a late tick dt is the time that has passed
///    since. A wall at rest asks for no more at any speed of the hand, so it is never slowed. The
///    wrench shrinks at once. It comes after 4: a force that wants to be huge is slewed from the
///    limit on.
/// 6. Passivity observer and controller on the wrench that is held (keep_passive), which bounds the
///    energy given to the hand: only this wrench is what the hand gets. Not for an open-loop
///    device, where it moves nothing; without damping while contacts fade or are stale, where the
///    wanted wrench is already the most that may remain. That of an admittance device acts on the
///    body that the wrench moves (servo/admittance/energy_ledger.h).
/// 7. Saturation and slew again, of the sum with the damping of 6.
/// 8. The weight of the arm itself, which a device with a table of it is told to hold up
/// (weight.h). C. Clamp of the motors' currents, in each driver: it alone knows the linkage.
SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt);

}  // namespace haptic
