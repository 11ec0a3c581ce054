// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/wire.h"
#include "servo/solve/body/soft_contact.h"

namespace haptic {

/// What a contact set asks of a soft proxy this tick: its contacts as one-sided springs, and what
/// these leave of its linearised wrench.
struct SoftContacts {
  std::array<SoftContact, kMaxContacts> contacts;
  std::array<uint32_t, kMaxContacts> objects;  // that each is on
  std::array<Vec3, kMaxContacts> away_W;       // of each, the object's own normal
  size_t size = 0;
  bool finite = true;

  bool has_rest = false;
  uint32_t rest_object = 0;
  Pose X_WC0;               // where the tool was linearised, carried along with its object
  Wrench F_rest_W;          // about C there
  Mat6 K_rest;              // of small motions from there
  double trust_radius = 0;  // of any point of the tool [m]
  double push0 = 0;         // of the springs on that object, there [N]
  size_t n_springs = 0;     // of them: the first contacts

  bool has_brake = false;
  Mat6 B;           // of the tool's twist about C, relative to rest_object
  Pose X_WO_brake;  // of that object
  Twist V_WO_brake;

  std::span<const SoftContact> view() const { return {contacts.data(), size}; }
};

struct SoftCarry {
  std::array<Pose, kMaxObjects> X_WO;   // this tick
  std::array<Twist, kMaxObjects> V_WO;  // this tick
  double weight = 1;                    // share of the contacts that is left, by age
  double stiffness = 1000;              // of contacts that name none [N/m]
  double damping = 0;                   // of each along its normal [N·s/m]
};

/// Carries a set to this tick: contacts move with their objects, and so does the linearised wrench
/// W(δ) = F0 + K δ of a dense detector. Of it the springs of its clusters take their part, so that
/// what is rendered is never attractive (rest_wrench) and touches nothing twice:
///   F_rest = F0 − Σ k d w,  K_rest = K + Σ k w wᵀ,  w = (n, r × n)
/// Contacts of wrench_object stand first in the set.
SoftContacts carry_soft_contacts(const ContactSet& set, const RigidBody& tool,
                                 const SoftCarry& carry);

/// Fades the springs whose point went further along their plane than that holds, over a tenth of
/// Contact::extent (0: not known, no bound), with the tool at X_WC: nothing is felt past an edge,
/// though the set is old.
void fade_past_extent(const ContactSet& set, const Pose& X_WC, SoftContacts& contacts);

/// The rest of the linearised wrench at a place of the tool: γ (F_rest + K_rest δ), δ the motion
/// since, cut where a point of the tool went further than the trust radius; γ is what the springs
/// of the object push at `end` over what they pushed then, at most 1: where they let go, so does
/// it. Against the object's normal it takes no more than half of what they push, so that both
/// together never pull. `end` is how the tool will be at the end of the step, or how it is. Add the
/// springs of view().
BodyWrench rest_wrench(const SoftContacts& contacts, const RigidBody& tool, const Pose& X_WC,
                       const BodyMotion& end);

/// What brakes the points that approach, B (V − V_object) about C: viscous, so that a tool about to
/// touch is slowed (McNeely, Puterbaugh, Troy 1999). Nothing where that would hold a tool which
/// leaves: against the object's normal at any of its contacts.
BodyWrench brake_wrench(const SoftContacts& contacts, const BodyMotion& body);

}  // namespace haptic
