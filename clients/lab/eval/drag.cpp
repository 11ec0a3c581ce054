// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/drag.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace haptic {
namespace {

constexpr double kStart = 2;    // [s]; transient that is not evaluated
constexpr double kPeriods = 2;  // evaluated after that

}  // namespace

double free_space_drag(const SoftProxyModel& model, BodyTick tick, const FreeMotion& motion) {
  const double omega = 2 * std::numbers::pi * motion.frequency;
  const auto start = static_cast<int>(kStart / motion.dt);
  const auto end = start + static_cast<int>(kPeriods / (motion.frequency * motion.dt));
  const ContactSet none{};
  tick.contacts = &none;
  SoftProxyState state;
  double most = 0;
  for (int i = 0; i < end; ++i) {
    const double angle = omega * motion.dt * i;
    tick.dt = motion.dt;
    tick.hand.X_WT.p = {motion.speed / omega * std::sin(angle), 0, 0};
    tick.hand.V_WT.v = {motion.speed * std::cos(angle), 0, 0};
    tick.hand.X_WT.q = from_rotation_vector({0, motion.turning / omega * std::sin(angle), 0});
    tick.hand.V_WT.w = {0, motion.turning * std::cos(angle), 0};
    const Wrench felt = solve_soft_proxy(model, state, tick).F_hand_W;
    if (i >= start) most = std::max({most, norm(felt.f), norm(felt.t)});
  }
  return most;
}

double drag_in_closed_form(const BodyTick& tick, const FreeMotion& motion) {
  const double omega = 2 * std::numbers::pi * motion.frequency, m = tick.tool.mass;
  const std::complex<double> coupling{tick.coupling.translational_stiffness,
                                      omega * tick.coupling.translational_damping};
  return m * omega * motion.speed * std::abs(coupling) / std::abs(coupling - m * omega * omega);
}

void eval_drag(const Rows& all) {
  Rows rows = all.of("free space at 2 m/s");
  SoftProxyModel model;
  BodyTick tick;
  tick.coupling = {1000, 9, 2, 3e-3, 0, 0};
  for (const auto& [solver, name] :
       {std::pair{SoftSolver::kDirect, "direct"}, {SoftSolver::kQuasiStatic, "quasi-static"}}) {
    model.solver = solver;
    const double drag = free_space_drag(model, tick, {});
    rows.add(std::string(name) + ", drag", drag, "N", kMustBeZero);
  }
  model.solver = SoftSolver::kPenaltyDynamics;
  const FreeMotion straight{.turning = 0};
  for (const double mass : {0.02, 0.1}) {
    tick.tool.mass = mass;
    const std::string name = "penalty dynamics, " + readable(mass, "kg");
    rows.add({{name + ", drag", free_space_drag(model, tick, straight), "N"},
              {name + ", drag in closed form", drag_in_closed_form(tick, straight), "N"}});
  }
}

}  // namespace haptic
