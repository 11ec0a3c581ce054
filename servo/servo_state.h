// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/wire.h"
#include "servo/admittance/energy_ledger.h"
#include "servo/admittance/following.h"
#include "servo/admittance/seen_space.h"
#include "servo/render/grasped.h"
#include "servo/render/light_bodies.h"
#include "servo/render/solvers.h"
#include "servo/safety/contact_age.h"
#include "servo/safety/coupling.h"
#include "servo/safety/safety.h"

namespace haptic {

/// What an admittance device needs beside.
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

/// Which placing of contact's proxy the force is built on.
struct ReseedMark {
  uint64_t generation = 0;  // of the writer of the ContactSet
  uint64_t count = 0;       // ContactSet::reseeds
  bool operator==(const ReseedMark&) const = default;
};

/// What the objects have been pushed with (ServoFrame).
struct PushCounters {
  std::array<Wrench, kMaxObjects> impulse_W{};
  std::array<Wrench, kMaxObjects> impulse_time_W{};  // until t_ns
  std::array<Wrench, kMaxObjects> last_W{};          // part of impulse_W, of the last tick
  Vec3 forgotten_W;
  int64_t since_ns = 0;  // the first tick
  int64_t t_ns = 0;      // this tick
};

/// How the processes keep up, since the last judgement of it (pace.h).
struct Pace {
  int64_t since_ns = 0;
  uint64_t skipped = 0, scene_seq = 0;  // then
  uint64_t n_ticks = 0, n_late_contacts = 0;
  uint32_t flags = 0;  // of the judgement
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
  ContactAge age;
  Pace pace;
  SafetyState safety;
  AdmittanceState admittance;  // of an admittance device
  Clutch clutch;
  bool started = false;
  bool controlled = false;  // a ControlFrame has come
  Pose X_WT;                // last tick's tool
  Pose X_WP;                // last tick's proxy
  int64_t t_ns = 0;
  uint64_t contact_generation = 0;
  ReseedMark reseeds;
  PushCounters pushes;
};

/// What the shell measured and received for this tick. Pointers may be null: nothing received yet.
struct ServoInput {
  uint64_t tick = 0;
  int64_t t_ns = 0;  // deadline of the tick
  int64_t realtime_ns = 0;
  int64_t wake_late_ns = 0;
  uint64_t skipped = 0;
  bool released = false;  // the servo was held up so long that the device was let go
  DeviceState device{};
  const ContactSet* contacts = nullptr;
  uint64_t contact_generation = 0;  // of the segment the set came from
  const SceneFrame* scene = nullptr;
  const ControlFrame* control = nullptr;
};

}  // namespace haptic
