// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/body/soft_contact.h"

namespace haptic {

/// The contacts of a soft proxy this tick: one-sided springs, and the rest of the linearised
/// wrench.
struct SoftContacts : ContactsNow<SoftContact> {
  bool has_rest = false;
  uint32_t rest_object = 0;
  Pose X_WC0;               // pose at which the wrench was linearised, carried with its object
  Wrench F_rest_W;          // about C there
  Mat6 K_rest;              // by small motions from there
  double trust_radius = 0;  // bound of any point's motion from there [m]
  double push0 = 0;         // of the springs on that object, at X_WC0 [N]
  size_t n_springs = 0;     // contacts 0 … n_springs − 1 are on that object

  bool has_brake = false;
  Mat6 B;           // times the tool's twist about C, relative to rest_object
  Pose X_WO_brake;  // of that object
  Twist V_WO_brake;
};

struct SoftCarry : TickScene {
  double stiffness = 1000;  // of contacts that give none [N/m]
  double damping = 0;       // of each contact along its normal [N·s/m]
};

/// Carries a set to this tick. The contacts move with their objects, and so does the linearised
/// wrench W(δ) = F0 + K δ of a dense detector. The springs of its clusters are subtracted, so that
/// nothing is counted twice:
///   F_rest = F0 − Σ k d w,  K_rest = K + Σ k w wᵀ,  w = (n, r × n)
/// Contacts of wrench_object come first in the set.
SoftContacts carry_soft_contacts(const ContactSet& set, const ToolBody& tool,
                                 const SoftCarry& carry);

/// Fades springs whose point has moved along the contact plane to more than Contact::extent (0:
/// unknown, no bound), over a tenth of it, with the tool at X_WC: even with an old set nothing is
/// felt past an edge.
void fade_past_extent(const Pose& X_WC, SoftContacts& contacts);

/// The rest of the linearised wrench at X_WC: γ (F_rest + K_rest δ), δ the motion from X_WC0, cut
/// at the trust radius. γ ≤ 1 is the push of the object's springs at `end` over their push at
/// X_WC0, so the rest vanishes where the springs let go. Against the object's normal the force is
/// at most half of what the springs push, so the sum never pulls. `end` is the motion at the end of
/// the step, or the present one. Does not include the springs of view().
BodyWrench rest_wrench(const SoftContacts& contacts, const ToolBody& tool, const Pose& X_WC,
                       const BodyMotion& end);

/// Viscous brake of approaching points, B (V − V_object) about C, which slows a tool about to touch
/// (McNeely, Puterbaugh, Troy 1999). Zero if it would hold back a leaving tool, that is, act
/// against the object's normal at any of its contacts.
BodyWrench brake_wrench(const SoftContacts& contacts, const BodyMotion& body);

}  // namespace haptic
