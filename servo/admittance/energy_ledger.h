// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/admittance/virtual_body.h"

namespace haptic {

/// The energy that the virtual body may hold: it came through the port from the hand, and from the
/// scene, and has not been used up [J].
struct EnergyLedger {
  BodyEnergy held;
  Pose X_BH;           // handle at the last sample
  bool known = false;  // false: no sample yet
};

/// Adds the work of the hand since the last sample: its mean wrench times the measured motion.
void observe_work(EnergyLedger& ledger, const Wrench& F_hand_B, const Pose& X_BH);

/// Passivity controller of an admittance device. A passive body never holds more energy than it was
/// given, so a body that would has made it: by the delay between the force and the motion that
/// answers it. `to` is slowed until
///   ½ M v² ≤ max(E + f·(x_to − x_measured) + slack, 0),
/// E the energy observed and the second term what the hand, with its present force, will have put
/// in when the arm is there; turning likewise, by a ledger of its own: a deficit of moving is paid
/// by moving, one of turning by turning. Braking the body is an implicit damper: it never reverses
/// and adds no delay. (The dual of the series damper of Hannaford & Ryu 2002, a velocity β f added
/// in parallel, would follow a force that is a tick old: with a hand that damps it is what has just
/// become unstable.)
struct LedgerLimit {
  VirtualBody body;
  bool damped = false;
};
LedgerLimit keep_body_passive(const AdmittanceConfig& model, const EnergyLedger& ledger,
                              const VirtualBody& from, const VirtualBody& to,
                              const Wrench& F_hand_B, double dt);

/// Settles the tick: what the scene gave to `free` on its way to `now` is added. What the body does
/// not hold (any more, with what the hand is about to put in) is used up; a deficit decays over
/// half a second and is bounded, as that of an impedance device (servo/safety/safety.h).
void settle_ledger(const AdmittanceConfig& model, EnergyLedger& ledger, const VirtualBody& free,
                   const VirtualBody& now, const Wrench& F_hand_B, double dt);

}  // namespace haptic
