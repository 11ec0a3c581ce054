// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance/virtual_body.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "servo/safety/safety.h"

namespace haptic {
namespace {

VirtualBody moved_on(const VirtualBody& body, const Twist& V_B, double dt) {
  return {moved(body.X_BH, dt * V_B), V_B};
}

/// The velocity after a braking impulse, which takes away momentum at most to rest.
Vec3 slowed(const Vec3& velocity, double inertia, double impulse) {
  const double momentum = inertia * norm(velocity);
  return momentum > impulse ? (1 - impulse / momentum) * velocity : Vec3{};
}

}  // namespace

VirtualBody stepped(const AdmittanceConfig& model, const VirtualBody& body, const Wrench& F_B,
                    double dt) {
  HAPTIC_ASSERT(dt > 0 && model.mass > 0 && model.inertia > 0);
  HAPTIC_ASSERT(model.damping >= 0 && model.rotational_damping >= 0);
  const auto next = [dt](double inertia, double damping, const Vec3& velocity, const Vec3& push) {
    return (inertia * velocity + dt * push) / (inertia + dt * damping);
  };
  return moved_on(body,
                  {next(model.mass, model.damping, body.V_BH.v, F_B.f),
                   next(model.inertia, model.rotational_damping, body.V_BH.w, F_B.t)},
                  dt);
}

VirtualBody braked(const AdmittanceConfig& model, const VirtualBody& body, double max_force,
                   double max_torque, double dt) {
  HAPTIC_ASSERT(dt > 0 && max_force >= 0 && max_torque >= 0);
  return moved_on(body,
                  {slowed(body.V_BH.v, model.mass, dt * max_force),
                   slowed(body.V_BH.w, model.inertia, dt * max_torque)},
                  dt);
}

VirtualBody bounded(const VirtualBody& from, const VirtualBody& to, const SpeedLimit& most,
                    double dt) {
  Twist V_B = to.V_BH;
  const bool moving_cut = saturate(V_B.v, most.moving);
  const bool turning_cut = saturate(V_B.w, most.turning);
  return moving_cut || turning_cut ? moved_on(from, V_B, dt) : to;
}

VirtualBody brought_to(const VirtualBody& from, const Pose& X_BH, double dt) {
  HAPTIC_ASSERT(dt > 0);
  return {X_BH, 1 / dt * way_between(from.X_BH, X_BH)};
}

BodyEnergy energy_of(const AdmittanceConfig& model, const Twist& V_BH) {
  return {model.mass * norm_squared(V_BH.v) / 2, model.inertia * norm_squared(V_BH.w) / 2};
}

}  // namespace haptic
