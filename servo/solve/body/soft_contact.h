// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "servo/solve/carried_contacts.h"
#include "servo/solve/coupled_body.h"

namespace haptic {

/// A contact as a one-sided spring of its stiffness k, and damper.
struct SoftContact : CarriedContact {
  Vec3 tool_point_C;   // on the tool, relative to its centre of mass
  double damping = 0;  // b [N·s/m]
};

/// Signed distance of the contact's two points along its normal [m], to second order:
///   g = n·δ + ½ κ |δ_t|²,  δ the way from the object's point to the tool's, δ_t = δ − (n·δ) n,
/// as far as fall_at goes; negative: overlap.
double gap_of(const SoftContact& contact, const Pose& X_WC);

/// One contact, linearised at the body's pose: its push is f = push + by_motion·(x, θ) +
/// by_twist·Δu along `unit`, the wrench about C of a force m = ∇g at the tool's point (n where the
/// surface is flat). For an approaching contact push is negative.
struct ContactRow {
  Wrench unit;
  double gap = 0;   // [m]
  double push = 0;  // −k g − b s, damped only where g < 0 [N]
  Twist by_motion, by_twist;
  Vec3 lever_W;  // r, from C to the tool's point
  Mat3 bend;     // ∂m/∂x, where is_bent
  bool is_bent = false;
};
ContactRow linearise(const SoftContact& contact, const BodyMotion& body);

/// The row of a contact that overlaps and pushes; empty otherwise.
std::optional<ContactRow> pushing_row(const SoftContact& contact, const BodyMotion& body);

/// Adds a row's push f and its Jacobians to the sum; the lever arm turns with the body if f > 0.
void add_row(const ContactRow& row, double push, BodyWrench& sum);

/// Adds the penalty force of one contact with its Jacobians: with lever r = R tool_point_C, g =
/// n·(x + r − p) and speed s = n·(v + ω×r − v_p),
///   f = −k g − b s,  F = f n,  T = r × F  where g < 0 and f > 0, else nothing: it never pulls.
/// ∂F/∂x = −k N, ∂F/∂θ = k N [r]× + b N [ω]× [r]×, ∂T/∂θ = [r]× ∂F/∂θ + [F]× [r]×, and so on with N
/// = n nᵀ (Otaduy & Lin 2006). On a curved surface m = ∇g, which turns with the place, stands for
/// n, so that the force is the gradient of ½ k g². Returns the push f [N].
double add_soft_contact(const SoftContact& contact, const BodyMotion& body, BodyWrench& sum);

/// Energy stored in the contacts that push [J], the same as soft_contact_wrench gives.
double soft_contact_energy(std::span<const SoftContact> contacts, const BodyMotion& body);

/// Sum of the penalty forces.
BodyWrench soft_contact_wrench(std::span<const SoftContact> contacts, const BodyMotion& body);

}  // namespace haptic
