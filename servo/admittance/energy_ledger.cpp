// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance/energy_ledger.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "servo/safety/safety.h"

namespace haptic {
namespace {

constexpr double kForgetTime = 0.5;  // decay of a deficit [s]
constexpr double kSlack = 20e-6;     // energy that is always allowed: 2 kg at 4 mm/s [J]

/// Work of a wrench on a way.
BodyEnergy work(const Wrench& F, const Twist& way) {
  return {dot(F.f, way.v), dot(F.t, way.w)};
}

BodyEnergy operator+(const BodyEnergy& a, const BodyEnergy& b) {
  return {a.moving + b.moving, a.turning + b.turning};
}

/// The share of a speed that a bound of its energy leaves.
double share_of(double energy, double most) {
  const double allowed = std::max(most + kSlack, 0.0);
  return energy > allowed ? std::sqrt(allowed / energy) : 1;
}

double settled(double held, double gift, double most, double dt) {
  const double left = std::clamp(held + std::max(gift, 0.0), -kPassivityDebt, most);
  return left < 0 ? left * (1 - std::min(dt / kForgetTime, 1.0)) : left;
}

}  // namespace

void observe_work(EnergyLedger& ledger, const Wrench& F_hand_B, const Pose& X_BH) {
  HAPTIC_ASSERT(is_finite(F_hand_B) && is_finite(X_BH));
  if (ledger.known) ledger.held = ledger.held + work(F_hand_B, way_between(ledger.X_BH, X_BH));
  ledger.X_BH = X_BH;
  ledger.known = true;
}

LedgerLimit keep_body_passive(const AdmittanceConfig& model, const EnergyLedger& ledger,
                              const VirtualBody& from, const VirtualBody& to,
                              const Wrench& F_hand_B, double dt) {
  HAPTIC_ASSERT(dt > 0 && is_finite(F_hand_B));
  if (!ledger.known) return {to};
  const BodyEnergy most = ledger.held + work(F_hand_B, way_between(ledger.X_BH, to.X_BH));
  const BodyEnergy energy = energy_of(model, to.V_BH);
  const double moving = share_of(energy.moving, most.moving);
  const double turning = share_of(energy.turning, most.turning);
  if (moving == 1 && turning == 1) return {to};
  const Twist V_B{moving * to.V_BH.v, turning * to.V_BH.w};
  return {{moved(from.X_BH, dt * V_B), V_B}, true};
}

void settle_ledger(const AdmittanceConfig& model, EnergyLedger& ledger, const VirtualBody& free,
                   const VirtualBody& now, const Wrench& F_hand_B, double dt) {
  HAPTIC_ASSERT(dt > 0);
  if (!ledger.known) return;
  const BodyEnergy before = energy_of(model, free.V_BH), after = energy_of(model, now.V_BH);
  const BodyEnergy ahead = work(F_hand_B, way_between(ledger.X_BH, now.X_BH));
  // a deficit that the hand will have made up for is one all the same
  const auto most = [](double energy, double coming) { return std::max(energy - coming, 0.0); };
  ledger.held = {settled(ledger.held.moving, after.moving - before.moving,
                         most(after.moving, ahead.moving), dt),
                 settled(ledger.held.turning, after.turning - before.turning,
                         most(after.turning, ahead.turning), dt)};
}

}  // namespace haptic
