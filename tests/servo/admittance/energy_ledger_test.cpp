// SPDX-License-Identifier: GPL-3.0-or-later
// The ledger of a virtual body: a body that has been given its energy goes on, one that has made it
// is braked. The hand's work is known in closed form.
#include "servo/admittance/energy_ledger.h"

#include <cmath>

#include "proto/math/motion_metric.h"
#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

AdmittanceConfig ledger_body(double mass) {
  AdmittanceConfig model;
  model.mass = mass;
  model.damping = 0;
  model.inertia = 4e-3;
  model.rotational_damping = 0;
  return model;
}

VirtualBody going(const Twist& V) {
  return {moved({}, kTick * V), V};
}

}  // namespace

TEST_CASE("ledger: the work of moving and of turning, apart and signed", "[servo]") {
  EnergyLedger ledger;
  observe_work(ledger, {{100, 0, 0}, {}}, {{1, 0, 0}, {}});
  CHECK(ledger.held.moving == 0);  // no motion is known before the first sample
  observe_work(ledger, {{2, 5, 0}, {0, 0, 0.5}}, {{1.01, 0, 0}, from_rotation_vector({0, 0, 0.1})});
  CHECK(ledger.held.moving == Approx(0.02));
  CHECK(ledger.held.turning == Approx(0.05));
  observe_work(ledger, {{2, 0, 0}, {}}, {{1.0, 0, 0}, from_rotation_vector({0, 0, 0.1})});
  CHECK(ledger.held.moving == Approx(0).margin(1e-12));
  CHECK(ledger.held.turning == Approx(0.05));
}

TEST_CASE("ledger: before the first sample nothing is braked", "[servo]") {
  const VirtualBody to = going({{1, 0, 0}, {0, 0, 10}});
  const LedgerLimit limit = keep_body_passive(ledger_body(2), {}, {}, to, {}, kTick);
  CHECK_FALSE(limit.damped);
  CHECK(limit.body.V_BH.v == to.V_BH.v);
}

TEST_CASE("ledger: a body that made its energy is slowed to what it was given", "[servo]") {
  EnergyLedger ledger;
  ledger.known = true;
  ledger.held = {0.09, 1};
  // 2 kg at 0.5 m/s hold 250 mJ; 90 mJ are 0.3 m/s; the turning has its own, and enough
  const VirtualBody to = going({{0.3, 0.4, 0}, {0, 0, 10}});
  const LedgerLimit limit = keep_body_passive(ledger_body(2), ledger, {}, to, {}, kTick);
  CHECK(limit.damped);
  CHECK_THAT(limit.body.V_BH.v, IsNear({0.18, 0.24, 0}, 1e-4));
  CHECK_THAT(limit.body.V_BH.w, IsNear({0, 0, 10}, 1e-12));
  CHECK_THAT(limit.body.X_BH.p, IsNear({0.18e-3, 0.24e-3, 0}, 1e-7));
}

TEST_CASE("ledger: what the hand is about to put in counts", "[servo]") {
  EnergyLedger ledger;
  ledger.known = true;
  const VirtualBody to = going({{0.1, 0, 0}, {}});
  // 10 mJ for 2 kg: 100 N over 0.1 mm
  CHECK_FALSE(keep_body_passive(ledger_body(2), ledger, {}, to, {{101, 0, 0}, {}}, kTick).damped);
  CHECK(keep_body_passive(ledger_body(2), ledger, {}, to, {{90, 0, 0}, {}}, kTick).damped);
  CHECK(keep_body_passive(ledger_body(2), ledger, {}, to, {{-101, 0, 0}, {}}, kTick).damped);
}

TEST_CASE("ledger: what the body does not hold is used up, what the scene gave is added",
          "[servo]") {
  const AdmittanceConfig model = ledger_body(2);
  EnergyLedger ledger;
  ledger.known = true;
  ledger.held = {5, 5};
  const VirtualBody at_rest, fast = going({{0.5, 0, 0}, {}});
  EnergyLedger stopped = ledger;
  settle_ledger(model, stopped, at_rest, at_rest, {}, kTick);
  CHECK(stopped.held.moving == Approx(0).margin(1e-12));
  EnergyLedger keeps = ledger;
  settle_ledger(model, keeps, fast, fast, {}, kTick);
  CHECK(keeps.held.moving == Approx(0.25));
  EnergyLedger pushed;
  pushed.known = true;
  settle_ledger(model, pushed, at_rest, fast, {}, kTick);
  CHECK(pushed.held.moving == Approx(0.25));
}

TEST_CASE("ledger: a deficit is bounded and decays to 1/e in half a second", "[servo]") {
  EnergyLedger ledger;
  ledger.known = true;
  ledger.held = {-3, -0.01};
  const VirtualBody at_rest;
  settle_ledger(ledger_body(2), ledger, at_rest, at_rest, {}, kTick);
  CHECK(ledger.held.moving == Approx(-0.05).epsilon(0.01));
  for (int k = 1; k < 500; ++k) settle_ledger(ledger_body(2), ledger, at_rest, at_rest, {}, kTick);
  CHECK(ledger.held.moving == Approx(-0.05 * std::exp(-1)).epsilon(0.01));
  CHECK(ledger.held.turning == Approx(-0.01 * std::exp(-1)).epsilon(0.01));
}
