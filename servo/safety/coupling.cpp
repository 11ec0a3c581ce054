// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/coupling.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRampTime = 0.200;  // [s]

Coupling along(const CouplingRamp& ramp) {
  const double share = std::min(ramp.time / kRampTime, 1.0);
  Coupling now = ramp.to;
  if (share == 1) return now;
  for (double Coupling::*const k :
       {&Coupling::translational_stiffness, &Coupling::translational_damping,
        &Coupling::rotational_stiffness, &Coupling::rotational_damping}) {
    now.*k = ramp.from.*k + share * (ramp.to.*k - ramp.from.*k);
  }
  return now;
}

}  // namespace

Coupling ramp_coupling(CouplingRamp& ramp, const Coupling& wanted, double dt) {
  HAPTIC_ASSERT(dt > 0 && ramp.time >= 0);
  if (wanted != ramp.to) ramp = {along(ramp), wanted, 0};
  ramp.time += dt;
  return along(ramp);
}

Vec3 coupling_force(const Coupling& coupling, const CouplingInput& input) {
  const Vec3 stretch_W = input.proxy_W - input.tool_W;
  const double length = norm(stretch_W);
  if (length == 0) return {};
  if (coupling.translational_damping == 0) return coupling.translational_stiffness * stretch_W;
  const Vec3 along_W = stretch_W / length;
  const double closing = dot(input.proxy_velocity_W - input.tool_velocity_W, along_W);
  const double force = coupling.translational_stiffness * length +
                       input.share * coupling.translational_damping * closing;
  return std::max(force, 0.0) * along_W;
}

}  // namespace haptic
