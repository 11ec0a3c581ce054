// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/free_space_drag.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace haptic {
namespace {

constexpr double kStart = 2;    // until the start is over [s]
constexpr double kPeriods = 2;  // looked at

}  // namespace

double free_space_drag(const SoftProxyModel& model, const FreeMotion& motion) {
  const double omega = 2 * std::numbers::pi * motion.frequency;
  const auto start = static_cast<int>(kStart / motion.dt);
  const auto end = start + static_cast<int>(kPeriods / (motion.frequency * motion.dt));
  SoftProxyState state;
  double most = 0;
  for (int i = 0; i < end; ++i) {
    const double angle = omega * motion.dt * i;
    SoftProxyTick tick;
    tick.dt = motion.dt;
    tick.hand.X_WT.p = {motion.speed / omega * std::sin(angle), 0, 0};
    tick.hand.V_WT.v = {motion.speed * std::cos(angle), 0, 0};
    const double felt = norm(solve_soft_proxy(model, state, tick).F_hand_W.f);
    if (i >= start) most = std::max(most, felt);
  }
  return most;
}

double drag_in_closed_form(const SoftProxyModel& model, const FreeMotion& motion) {
  if (model.solver != SoftSolver::kPenaltyDynamics) return 0;
  const double omega = 2 * std::numbers::pi * motion.frequency, m = model.tool.mass;
  const std::complex<double> coupling{model.coupling.translational_stiffness,
                                      omega * model.coupling.translational_damping};
  return m * omega * motion.speed * std::abs(coupling) / std::abs(coupling - m * omega * omega);
}

}  // namespace haptic
