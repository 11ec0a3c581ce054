// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/limits.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kThermalTime = 10;     // time constant of the thermal low-pass [s]
constexpr double kThermalBand = 0.2;    // last part of the budget, over which the limit falls
constexpr double kEdgeShare = 0.3;      // largest force of the workspace edge over max_force
constexpr double kEdgeWidth = 5e-3;     // way over which the edge's spring reaches that [m]
constexpr double kEdgeAngle = 50e-3;    // the same for turning: 5 mm at 100 mm [rad]
constexpr double kBelow = 1 - 0x1p-50;  // slightly less than 1: rounding must not exceed a limit

double sustained(double peak, double continuous, double heat) {
  if (continuous <= 0 || continuous >= peak) return peak;
  const double budget = continuous * continuous;
  const double left = std::clamp((budget - heat) / (kThermalBand * budget), 0.0, 1.0);
  return continuous + left * (peak - continuous);
}

/// Spring against a displacement, which begins at `edge` and saturates `width` beyond it.
Vec3 edge_spring(const Vec3& out, double edge, double width, double most) {
  if (edge <= 0) return {};
  const double beyond = norm(out) - edge;
  if (beyond <= 0) return {};
  return -kEdgeShare * most * std::min(beyond / width, 1.0) * normalized(out);
}

}  // namespace

bool saturate(Vec3& a, double limit) {
  const double length = norm(a);
  if (length <= limit) return false;
  // scaled down first: a huge but finite vector has an infinite norm
  const double largest = std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  a = limit * kBelow * normalized(a / largest);
  return true;
}

bool saturate(Wrench& F, const WrenchLimit& limit) {
  const bool force_cut = saturate(F.f, limit.force);
  const bool torque_cut = saturate(F.t, limit.torque);
  return force_cut || torque_cut;
}

WrenchLimit sustainable(const SafetyLimits& limits, const MotorHeat& heat) {
  return {sustained(limits.max_force, limits.continuous_force, heat.force),
          sustained(limits.max_torque, limits.continuous_torque, heat.torque)};
}

MotorHeat heated(const MotorHeat& heat, const Wrench& F_B, double dt) {
  const double share = dt / kThermalTime;
  return {heat.force + share * (norm_squared(F_B.f) - heat.force),
          heat.torque + share * (norm_squared(F_B.t) - heat.torque)};
}

double torque_slew(const SafetyLimits& limits) {
  if (limits.torque_slew > 0) return limits.torque_slew;
  return limits.max_force > 0 ? limits.slew * limits.max_torque / limits.max_force : 0;
}

WrenchGrowth most_growth(const SafetyLimits& limits, const HandleStiffness& stiffness,
                         const HandleMotion& motion, double since) {
  WrenchGrowth most;
  most.force =
      limits.slew * since + stiffness.translational * motion.way + stiffness.turning * motion.turn;
  most.torque = stiffness.lever * most.force + stiffness.rotational * motion.turn +
                torque_slew(limits) * since;
  return most;
}

Wrench edge_wrench(const SafetyLimits& limits, const Pose& X_BH) {
  Wrench edge_B;
  edge_B.f = edge_spring(X_BH.p - limits.workspace_centre_B, limits.workspace_radius, kEdgeWidth,
                         limits.max_force);
  edge_B.t = edge_spring(to_rotation_vector(X_BH.q * conjugate(limits.workspace_rest_B)),
                         limits.workspace_turn, kEdgeAngle, limits.max_torque);
  return edge_B;
}

}  // namespace haptic
