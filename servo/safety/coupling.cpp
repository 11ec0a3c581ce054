// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/coupling.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRampTime = 0.200;  // [s]

Coupling along(const CouplingRamp& ramp) {
  const double share = std::min(ramp.time / kRampTime, 1.0);
  const auto between = [&](double from, double to) {
    return share < 1 ? from + share * (to - from) : to;
  };
  return {between(ramp.from.translational_stiffness, ramp.to.translational_stiffness),
          between(ramp.from.translational_damping, ramp.to.translational_damping),
          between(ramp.from.rotational_stiffness, ramp.to.rotational_stiffness),
          between(ramp.from.rotational_damping, ramp.to.rotational_damping)};
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
