// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "servo/model.h"
#include "servo/servo_state.h"

/// The values that a tick is made of. Each is returned by the function that makes it; the frame is
/// written once, at the end.
namespace haptic {

/// The device as this tick may use it.
struct Sample {
  DeviceState device;   // as measured; at the origin and at rest where it is not usable
  bool usable = false;  // finite, its orientation a rotation, and so is the tool that it places
};

/// The tool in the hand.
struct Tool {
  Pose X_WT;
  Twist V_WT;
  bool is_clutched = false;  // the workspace moves instead, and the tool stays
};

/// How the scene answers a tool.
struct Touch {
  TickScene scene;    // where the objects are, and what the hand holds of them
  Rendered rendered;  // before safety
  Coupling coupling;  // by which it is rendered
  Twist V_WP;         // of the proxy
  double depth = 0;   // of the tool below it [m]
  uint32_t flags = 0;
};

/// All that a tick comes to, of an impedance device or of an admittance device.
struct Outcome {
  Sample sample;
  Tool tool;
  Pose X_WG;  // the tool as it was asked about, for frames before the first contacts
  Touch touch;
  SafetyOutput safe;
  std::optional<FeltShare> felt;  // as safe.felt; none: objects are pushed with nothing
  Wrench F_device_B;              // that the device is told to hold
  Pose X_command_B;               // where it is told to go
  uint32_t flags = 0;
};

/// True if all numbers of the pose and the velocity are finite and the orientation is a rotation.
bool is_sound(const DeviceState& device);

/// Where an impedance device or the arm of an admittance device is. A sample that is finite but
/// absurd may overflow on its way into the scene: it is not usable either.
Sample sample_of(const ServoModel& model, const Clutch& clutch, const ServoInput& input);

/// True if a force may follow from where the device says it is: it answers and is homed.
bool is_usable(const DeviceState& device);

/// Sets coupling, renderer and solver as they are wanted, and the coupling in force.
void follow_control(const ServoModel& model, ServoState& state, const ServoInput& input);

/// How much of the contacts their age leaves.
ContactWeight weigh(ServoState& state, const ServoInput& input, double dt);

/// Brings the impulses and their integral up to this tick. The device holds the force of the last
/// one over the ticks that were missed since, until hapticd lets go (kReleaseAfterTicks): so each
/// of them has pushed as it did. An admittance device holds a place: nothing has pushed.
void continue_pushes(const ServoModel& model, PushCounters& pushes, int64_t t_ns);

/// True if the tool of these contacts is a body that may enter objects.
bool is_soft_body(const ContactSet* contacts);

/// The objects where they are in this tick, by the newest scene carried on by twist and pushes,
/// else where contact saw them; and the proxy for the tool, by the solver that goes with the
/// detector of the contacts, which begins with nothing of another's. `weight`: of the contacts, by
/// their age.
Touch touch_of(const ServoModel& model, ServoState& state, const ServoInput& input,
               const Tool& tool, const Coupling& coupling, double weight);

/// The coupling in force as the handle would feel it.
HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling);

/// What the inputs of this tick ask of safety. The wrench, and what is known of contacts and
/// touched surface, are the caller's to add. A clutch that is held closes the force.
SafetyInput safety_input(const ServoModel& model, ServoState& state, const ServoInput& input,
                         const Sample& sample, bool is_clutched);

/// Keeps what the next tick needs of this one, counts what the objects are pushed with, and writes
/// the frame.
ServoFrame settle(const ServoModel& model, ServoState& state, const ServoInput& input,
                  const ContactWeight& age, const Outcome& outcome);

}  // namespace haptic
