// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A change from one coupling to another, spread over time: a step in stiffness under a pressed
/// finger would be a step in force.
struct CouplingRamp {
  Coupling from, to;
  double time = 0;  // since the change began [s]
};

/// Coupling of this tick. After a change of `wanted` it goes linearly, within 200 ms, from the
/// coupling then in force to `wanted`.
Coupling ramp_coupling(CouplingRamp& ramp, const Coupling& wanted, double dt);

/// Force of the virtual coupling on the tool of a massless 3-DoF proxy, at the tool's origin, in W:
///   f = max(k_T |s| + share b_T (v_P − v_T)·ŝ, 0) ŝ,  s = x_P − x_T,  ŝ = s/|s|
/// The damper acts along the spring only: it brakes the stretching and never drags sideways. The
/// force never pushes the tool away from the proxy. Sources: Colgate, Stanley, Brown 1995; damping
/// as in Zilles & Salisbury 1995. The port is passive for device damping b > s·φ·k_T·dt/2 + s·φ·b_T
/// (Colgate & Schenkel 1997).
struct CouplingInput {
  Vec3 tool_W;
  Vec3 proxy_W;
  Vec3 tool_velocity_W;
  Vec3 proxy_velocity_W;
  double share = 1;  // of the damper, 0 to 1: it must fade along with the spring
};
Vec3 coupling_force(const Coupling& coupling, const CouplingInput& input);

}  // namespace haptic
