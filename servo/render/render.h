// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "proto/config/config.h"
#include "proto/config/coupling_margin.h"
#include "proto/wire/wire.h"
#include "servo/safety/safety.h"
#include "servo/solve/body/constrained6.h"
#include "servo/solve/body/soft_proxy.h"
#include "servo/solve/coupled_body.h"
#include "servo/solve/point/virtual_proxy.h"

namespace haptic {

/// How much the hand may feel of a client.
struct ClientLimits {
  double max_force = 0;  // of its wrench and planes [N]
  double max_power = 0;  // that it gives the hand, over a second [W]
};

/// All that is constant after start.
struct ServoModel {
  uint32_t hand = kFirstHand;
  double dt = 1e-3;          // nominal period [s]
  double sim_period = 1e-3;  // [s]
  DeviceMap map;
  Coupling coupling;  // as configured; the ControlFrame may change it
  // of the device alone: what it holds of any coupling; damping 0: not known
  CoupledAxis moving{}, turning{};
  SafetyLimits limits;
  int32_t dead_man_button = -1;
  Renderer renderer{};  // as configured; the ControlFrame may change it
  Materials materials;
  double proxy_radius = 0;       // of virtual-proxy3 [m]
  ToolBody tool = kUnknownTool;  // until contact has baked it
  ProxyConfig proxy;    // its solver is each renderer's own, or this one, or the ControlFrame's
  SoftProxyModel soft;  // its solver and bound are those of each tick
  Constrained6Model constrained6;
  std::array<ClientLimits, kMostClients> clients{};
  std::optional<AdmittanceConfig> admittance;  // the virtual body; none: an impedance device
};

/// One tick, as a solver is asked about it.
struct RenderQuestion {
  const ContactSet& contacts;
  const TickScene& scene;
  Coupling coupling;  // in force
  Pose X_WT;          // the tool
  Twist V_WT;
  std::optional<Pose> X_WT_before;  // in the last tick
  int64_t t_ns = 0;
  std::optional<SoftSolver> soft_solver;  // in force; none: the session's, or the renderer's own
};

/// A renderer's answer to a tick, before safety, by its solver: a class of any *_solver.h of this
/// folder that the line in proto/wire/renderers.def names. It is copyable, starts without
/// arguments, keeps in its members what it needs in the next tick, and has
///   Rendered render(const ServoModel& model, const RenderQuestion& question,
///                   ContactSolvers& solvers)
/// which allocates nothing and never throws.
struct Rendered {
  Rendered() = default;
  explicit Rendered(const TickScene& scene) : push_W(scene.X_WO.size()) {}

  Pose X_WP;                  // the proxy
  std::optional<Twist> V_WP;  // where its solver knows it
  Wrench F_W;                 // of the coupling on the tool, at its origin
  Vec3 surface_W;             // velocity of what carries the proxy, at the tool's origin
  Vec3 surface_turning_W;     // its angular velocity, where the tool is a body
  Vec3 held_back_W;           // how far friction holds the proxy back
  int n_pushing = 0;          // contacts
  bool finite = true;         // the contacts were
  bool converged = true;
  PerObject<Wrench> push_W;  // of each object on the proxy, at its origin
};

}  // namespace haptic
