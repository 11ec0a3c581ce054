// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/behind.h"
#include "proto/wire/mapping.h"
#include "proto/wire/other_tools.h"
#include "proto/wire/renderer.h"
#include "proto/wire/wire.h"
#include "servo/admittance/energy_ledger.h"
#include "servo/admittance/following.h"
#include "servo/admittance/seen_space.h"
#include "servo/given/felt_clients.h"
#include "servo/pushes.h"
#include "servo/render/any_solver.h"  // made of the renderers' lines: renderer_types.cmake
#include "servo/render/grasped.h"
#include "servo/render/light_bodies.h"
#include "servo/render/render.h"
#include "servo/safety/contact_age.h"
#include "servo/safety/safety.h"
#include "servo/safety/weight.h"

/// The types of a tick (its state, its inputs, and the values that its stages return) and its first
/// stage. The frame is written once, at the end (step.h).
namespace haptic {

/// The part of the state that only an admittance device has.
struct AdmittanceState {
  uint64_t tick = 0;  // the last one
  VirtualBody body;
  Pose X_command_B;             // of the last tick
  CommandedWays commanded;      // until then
  bool started = false;         // the body has a pose
  bool contacts_finite = true;  // in the last tick
  int waited = 0;               // ticks until now that the body has waited for contact
  Wrench F_scene_B;             // of the springs of a soft body, in the last tick
  EnergyLedger ledger;
  SeenSpace seen;
};

/// A change from one coupling to another, spread over time: a step in stiffness under a pressed
/// finger would be a step in force.
struct CouplingRamp {
  Coupling from, to;
  double time = 0;  // since the change began [s]
};

/// How the processes keep up, since the last judgement of it (pace.h).
struct Pace {
  int64_t since_ns = 0;
  uint64_t skipped = 0, scene_seq = 0;  // then
  uint64_t n_ticks = 0, n_late_contacts = 0;
  uint32_t flags = 0;  // of the judgement
};

/// The state of rendering between ticks.
struct RenderState {
  AnySolver solver;                // that of the last tick; none: the next one begins anew
  ContactSolvers contact_solvers;  // memory of rigid ones; nothing persists in it

  void forget() { solver = {}; }
};

/// All that survives a tick.
struct ServoState {
  Coupling coupling;  // in force
  CouplingRamp ramp;
  Renderer renderer{};                    // wanted
  std::optional<SoftSolver> soft_solver;  // in use, of a soft body; none: the session's
  bool letting_go = false;                // another one is wanted, and the force is not yet zero
  RenderState render;                     // the solver in use
  GraspState grasp;
  LightBodies light;
  std::array<double, kMostHands> tool_shares{};  // of what tools of other hands push with
  FeltClientsState clients;
  PlacedSurfaces surfaces;  // of clients, in the last tick
  Age age;
  Pace pace;
  BehindSince behind;
  SafetyState safety;
  WeightState weight;
  AdmittanceState admittance;  // of an admittance device
  Clutch clutch;
  bool started = false;
  bool controlled = false;  // a ControlFrame has come
  Pose X_WT;                // last tick's tool
  Pose X_WP;                // last tick's proxy
  int64_t t_ns = 0;
  uint64_t contact_generation = 0;  // of the writer of the last ContactSet
  uint64_t reseeds = 0;             // ContactSet::reseeds, on which the force is built
  PushCounters pushes;
};

/// The inputs of a tick, as the shell measured and received them. Pointers may be null: nothing
/// received yet.
struct ServoInput {
  uint64_t tick = 0;
  int64_t t_ns = 0;  // deadline of the tick
  int64_t realtime_ns = 0;
  int64_t wake_late_ns = 0;
  uint64_t skipped = 0;
  bool released = false;  // the servo was held up so long that the device was let go
  DeviceState device{};
  Wrench holding_B;  // that holds up the weight of the device's own arm; zero: none is known
  const ContactSet* contacts = nullptr;
  uint64_t contact_generation = 0;  // of the segment the set came from
  const SceneFrame* scene = nullptr;
  ToolStiffnesses tool_stiffness = {};  // of the last objects of the scene: tools of other hands
  const ControlFrame* control = nullptr;
};

/// The device as this tick may use it.
struct Sample {
  DeviceState device;   // as measured; at the origin and at rest where it is not usable
  bool usable = false;  // finite, its orientation a rotation, and so is the tool that it places
};

/// The inputs of a tick as an impedance device and an admittance device both use them.
struct TickStart {
  Sample sample;
  ContactWeight age;   // how much of the contacts their age leaves
  SafetyInput safety;  // what the inputs ask of it; the wrench and what touches are still to come
  uint32_t flags = 0;
};

/// The tool in the hand.
struct Tool {
  Pose X_WT;
  Twist V_WT;
  bool is_clutched = false;  // the workspace moves instead, and the tool stays
};

/// The tool where the handle is; the clutch moves the workspace instead, and the tool stays at
/// X_WT_last.
inline Tool tool_at(const ServoModel& model, ServoState& state, const DeviceState& device,
                    const Pose& X_WT_last) {
  const Pose X_WT = state.started ? X_WT_last : tool_pose(model.map, state.clutch, device.X_BH);
  Tool tool{apply_clutch(model.map, state.clutch, device, X_WT), {}, state.clutch.held};
  if (!tool.is_clutched) tool.V_WT = tool_twist(model.map, device.X_BH, device.V_BH);
  return tool;
}

/// The answer of the scene to a tool.
struct Touch {
  TickScene scene;    // where the objects are, and what the hand holds of them
  Rendered rendered;  // before safety
  FeltOfClients clients;
  Coupling coupling;  // by which it is rendered
  Twist V_WP;         // of the proxy
  double depth = 0;   // of the tool below it [m]
  uint32_t flags = 0;
};

/// All that a tick comes to.
struct Outcome {
  Tool tool;
  Pose X_WG;  // the tool as it was asked about, for frames before the first contacts
  Touch touch;
  SafetyOutput safe;
  Wrench F_device_B;  // that the device is told to hold
  Pose X_command_B;   // where it is told to go
  uint32_t flags = 0;
};

/// Coupling of this tick. After a change of `wanted` it goes linearly, within 200 ms, from the
/// coupling then in force to `wanted`.
Coupling ramp_coupling(CouplingRamp& ramp, const Coupling& wanted, double dt);

/// True if all numbers of the pose and the velocity are finite, and less than 1e6 in SI units, and
/// the orientation is a rotation.
bool is_sound(const DeviceState& device);

/// True if a force may follow from where the device says it is: it answers and is homed.
inline bool is_usable(const DeviceState& device) {
  return (device.flags & kDeviceLost) == 0 && (device.flags & kDeviceHomed) != 0;
}

/// The renderer whose detector has found these contacts; null: there are none, or none of that
/// number is known.
inline const RendererRow* renderer_of(const ContactSet* contacts) {
  if (contacts == nullptr || !is_renderer(contacts->renderer)) return nullptr;
  return &row_of(static_cast<Renderer>(contacts->renderer));
}

/// True if the tool of these contacts is a body that may enter objects.
inline bool is_soft_body(const ContactSet* contacts) {
  const RendererRow* renderer = renderer_of(contacts);
  return renderer != nullptr && renderer->moves == Moves::kSoftBody;
}

/// Reads the inputs: the sample of the device, coupling, renderer and solver as they are wanted,
/// the age of the contacts, and what closes the force.
TickStart begin_tick(const ServoModel& model, ServoState& state, const ServoInput& input);

}  // namespace haptic
