// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_contact.h"

namespace haptic {

double gap_of(const SoftContact& contact, const Pose& X_WC) {
  return dot(contact.normal_W, X_WC * contact.tool_point_C - contact.object_point_W);
}

ContactRow linearise(const SoftContact& contact, const BodyMotion& body) {
  ContactRow row;
  row.lever_W = rotate(body.X_WC.q, contact.tool_point_C);
  row.gap = gap_of(contact, body.X_WC);
  const Vec3 &n = contact.normal_W, &r = row.lever_W;
  const double k = contact.stiffness, b = row.gap < 0 ? contact.damping : 0;
  const Vec3 turn = cross(r, n);
  row.unit = {n, turn};
  row.push = -k * row.gap - b * dot(n, velocity_at(body.V_WC, r) - contact.velocity_W);
  row.by_motion = {-k * n, -k * turn - b * cross(r, cross(n, body.V_WC.w))};
  row.by_twist = {-b * n, -b * turn};
  return row;
}

void add_row(const ContactRow& row, double push, BodyWrench& sum) {
  sum.F_W = sum.F_W + push * row.unit;
  add_outer(sum.by_motion, row.unit, row.by_motion);
  add_outer(sum.by_twist, row.unit, row.by_twist);
  if (push > 0) add_block(sum.by_motion, 3, 3, skew(push * row.unit.f) * skew(row.lever_W));
}

std::optional<ContactRow> pushing_row(const SoftContact& contact, const BodyMotion& body) {
  const ContactRow row = linearise(contact, body);
  return row.gap < 0 && row.push > 0 ? std::optional(row) : std::nullopt;
}

double add_soft_contact(const SoftContact& contact, const BodyMotion& body, BodyWrench& sum) {
  const std::optional<ContactRow> row = pushing_row(contact, body);
  if (!row) return 0;
  add_row(*row, row->push, sum);
  sum.energy += 0.5 * contact.stiffness * row->gap * row->gap;
  return row->push;
}

double soft_contact_energy(std::span<const SoftContact> contacts, const BodyMotion& body) {
  double energy = 0;
  for (const SoftContact& contact : contacts) {
    const std::optional<ContactRow> row = pushing_row(contact, body);
    if (row) energy += 0.5 * contact.stiffness * row->gap * row->gap;
  }
  return energy;
}

BodyWrench soft_contact_wrench(std::span<const SoftContact> contacts, const BodyMotion& body) {
  BodyWrench sum;
  for (const SoftContact& contact : contacts) add_soft_contact(contact, body, sum);
  return sum;
}

}  // namespace haptic
