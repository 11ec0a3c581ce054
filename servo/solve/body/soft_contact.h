// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "servo/solve/body/rigid_body.h"

namespace haptic {

/// A contact as a one-sided spring and damper, carried to this instant.
struct SoftContact {
  Vec3 tool_point_C;     // on the tool, seen from its centre of mass
  Vec3 object_point_W;   // on the object
  Vec3 normal_W;         // unit, from object to tool
  Vec3 velocity_W;       // of the object there
  double stiffness = 0;  // k [N/m]
  double damping = 0;    // b [N·s/m]
};

/// Signed distance of the contact's two points along its normal [m]; negative: they overlap.
double gap_of(const SoftContact& contact, const Pose& X_WC);

/// One contact linearised where the body is: its push is f = push + by_motion·(x, θ) + by_twist·Δu
/// along `unit`, n at the tool's point about C. Approaching contacts have one too: it is negative.
struct ContactRow {
  Wrench unit;
  double gap = 0;   // [m]
  double push = 0;  // −k g − b s, damped only where g < 0 [N]
  Twist by_motion, by_twist;
  Vec3 lever_W;  // r
};
ContactRow linearise(const SoftContact& contact, const BodyMotion& body);

/// The row of a contact that overlaps and pushes; none where it does nothing.
std::optional<ContactRow> pushing_row(const SoftContact& contact, const BodyMotion& body);

/// Adds what a row of push f > 0 does to the Jacobians of the sum; the lever turns with the body.
void add_row(const ContactRow& row, double push, BodyWrench& sum);

/// Adds the penalty force of one contact with its Jacobians: with lever r = R tool_point_C,
/// g = n·(x + r − p) and speed s = n·(v + ω×r − v_p),
///   f = −k g − b s,  F = f n,  T = r × F  where g < 0 and f > 0, else nothing: it never pulls.
/// ∂F/∂x = −k N, ∂F/∂θ = k N [r]× + b N [ω]× [r]×, ∂T/∂θ = [r]× ∂F/∂θ + [F]× [r]×, and so on with
/// N = n nᵀ (Otaduy & Lin 2006; the seed's −k d n has its normal pointing into the obstacle).
/// Returns the push f [N].
double add_soft_contact(const SoftContact& contact, const BodyMotion& body, BodyWrench& sum);

/// Stored in the springs of all that push [J]; soft_contact_wrench says it too, with much else.
double soft_contact_energy(std::span<const SoftContact> contacts, const BodyMotion& body);

/// The penalty force of all.
BodyWrench soft_contact_wrench(std::span<const SoftContact> contacts, const BodyMotion& body);

}  // namespace haptic
