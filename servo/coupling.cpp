// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/coupling.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kRampTime = 0.200;  // [s]

double ramp(double now, double wanted, double span, double dt) {
  const double step = std::max(span, std::fabs(wanted)) * dt / kRampTime;
  return now + std::clamp(wanted - now, -step, step);
}

}  // namespace

void ramp_coupling(Coupling& now, const Coupling& wanted, const Coupling& span, double dt) {
  now.translational_stiffness = ramp(now.translational_stiffness, wanted.translational_stiffness,
                                     span.translational_stiffness, dt);
  now.translational_damping =
      ramp(now.translational_damping, wanted.translational_damping, span.translational_damping, dt);
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
