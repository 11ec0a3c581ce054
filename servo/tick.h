// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/model.h"
#include "servo/servo_state.h"

/// The parts of a tick, which both ways of the step are made of: that of an impedance device, and
/// that of an admittance device.
namespace haptic {

/// Whether all numbers of the pose and the velocity are finite and the orientation is a rotation.
bool is_sound(const DeviceState& device);

/// True if a force may follow from where the device says it is: it answers and is homed.
bool is_usable(const DeviceState& device);

/// Begins a frame with what was measured. False when the sample cannot be used, because it is not
/// finite or its orientation is no rotation; the frame then shows the device at the origin.
bool note_sample(const ServoInput& input, ServoFrame& frame);

/// Coupling, renderer and solver that are wanted, and the coupling in force.
void follow_control(const ServoModel& model, ServoState& state, const ServoInput& input);

/// How much of the contacts their age leaves; noted in the frame.
ContactWeight weigh(ServoState& state, const ServoInput& input, double dt, ServoFrame& frame);

/// Brings the impulses and their integral up to this tick. The device holds the force of the last
/// one over the ticks that were missed since, until hapticd lets go (kReleaseAfterTicks): so each
/// of them has pushed as it did. An admittance device holds a place: nothing has pushed.
void continue_pushes(const ServoModel& model, PushCounters& pushes, int64_t t_ns);

/// Counts what the objects, where they are placed, are pushed with in this tick: the opposite of
/// what they push the proxy with, as far as the hand feels it. What no sim moves a body by is
/// forgotten: it is not given to the body later.
void note_pushes(const ServoModel& model, PushCounters& pushes, const ServoInput& input,
                 const TickScene& placed, const Rendered& rendered, const FeltShare& felt);

/// Where the objects are this tick: the newest scene carried on by twist and pushes, else where
/// contact saw them.
TickScene scene_of(const ServoState& state, const ServoInput& input);

/// Whether the tool of these contacts is a body that may enter objects.
bool is_soft_body(const ContactSet* contacts);

/// The proxy for the frame's tool, by the solver that goes with the detector of the contacts; it
/// begins with nothing of another's. Noted in the frame; what is held, in the scene.
Rendered render(const ServoModel& model, ServoState& state, const ServoInput& input,
                TickScene& scene, const Coupling& coupling, ServoFrame& frame);

/// The coupling in force as the handle would feel it.
HandleStiffness handle_stiffness(const DeviceMap& map, const Coupling& coupling);

/// Notes in the frame which inputs it used, and what they ask of safety.
SafetyInput note_inputs(const ServoModel& model, ServoState& state, const ServoInput& input,
                        ServoFrame& frame);

/// What safety came to, and what follows from its being closed.
void note_safety(ServoState& state, const Rendered& rendered, const SafetyOutput& safe,
                 ServoFrame& frame);

/// The proxy's velocity since the last tick and the counters of what the objects were pushed with;
/// and what the next tick needs of this.
void note_frame(ServoState& state, const ServoInput& input, const Rendered& rendered, bool usable,
                ServoFrame& frame);

}  // namespace haptic
