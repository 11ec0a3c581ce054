// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The parameters in force this tick; they follow the ControlFrame through a ramp.
struct Coupling {
  double translational_stiffness = 0;  // k_T [N/m]
  double translational_damping = 0;    // b_T [N·s/m]
  double rotational_stiffness = 0;     // k_R [N·m/rad], of a tool with six degrees of freedom
  double rotational_damping = 0;       // b_R [N·m·s/rad]

  bool operator==(const Coupling&) const = default;
};

/// A way from one set of parameters to another: a step in stiffness under a pressed finger would be
/// a step in force.
struct CouplingRamp {
  Coupling from, to;
  double time = 0;  // since it began [s]
};

/// The parameters of this tick, on a straight way of 200 ms to the wanted ones, from where they are
/// when the wish changes.
Coupling ramp_coupling(CouplingRamp& ramp, const Coupling& wanted, double dt);

/// Force of the virtual coupling on the tool of a massless 3-DoF proxy, at the tool's origin, in W:
/// f = k_T s + damper, s = x_P − x_T, the damper b_T (v_P − v_T) along s only, so that it brakes
/// the stretching of the spring and never drags sideways; |f| is never below zero: the force does
/// not pull. Sources: Colgate, Stanley, Brown 1995; god-object damping as in Zilles & Salisbury
/// 1995. The port is passive for device damping b > s·φ·k_T·dt/2 + s·φ·b_T (Colgate & Schenkel
/// 1997).
struct CouplingInput {
  Vec3 tool_W;
  Vec3 proxy_W;
  Vec3 tool_velocity_W;
  Vec3 proxy_velocity_W;
  double share = 1;  // of the damper: contacts that fade shorten the spring, and it must fade along
};
Vec3 coupling_force(const Coupling& coupling, const CouplingInput& input);

}  // namespace haptic
