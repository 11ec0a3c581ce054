// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_contact.h"

namespace haptic {
namespace {

/// The way from the object's point to the tool's.
struct Way {
  double along_normal = 0;  // [m]
  Vec3 tangential_W;
};

Way way_of(const SoftContact& contact, const Pose& X_WC) {
  const Vec3 way_W = X_WC * contact.tool_point_C - contact.point_W;
  const double along = dot(contact.normal_W, way_W);
  return {along, way_W - along * contact.normal_W};
}

/// ∂m/∂x of a surface that bends alike in all directions: κ across the normal, and where it goes
/// straight on the slope alone turns.
Mat3 bend_of(const Vec3& normal, const Vec3& tangential, double along, const Fall& fall) {
  const Vec3& n = normal;
  const Mat3 flat = Mat3{} + -1.0 * from_columns(n.x * n, n.y * n, n.z * n);
  if (fall.bend > 0 || !(along > 0)) return fall.bend * flat;
  const Vec3 t = tangential / along;
  return fall.slope / along * (flat + -1.0 * from_columns(t.x * t, t.y * t, t.z * t));
}

}  // namespace

double gap_of(const SoftContact& contact, const Pose& X_WC) {
  const Way way = way_of(contact, X_WC);
  if (!(contact.curvature > 0)) return way.along_normal;
  return way.along_normal + fall_at(contact.curvature, norm(way.tangential_W)).depth;
}

ContactRow linearise(const SoftContact& contact, const BodyMotion& body) {
  ContactRow row;
  row.lever_W = rotate(body.X_WC.q, contact.tool_point_C);
  const Way way = way_of(contact, body.X_WC);
  row.gap = way.along_normal;
  Vec3 n = contact.normal_W;
  const Vec3& r = row.lever_W;
  if (contact.curvature > 0) {
    const double along = norm(way.tangential_W);
    const Fall fall = fall_at(contact.curvature, along);
    row.gap += fall.depth;
    if (along > 0) n += fall.slope / along * way.tangential_W;
    row.bend = bend_of(contact.normal_W, way.tangential_W, along, fall);
    row.is_bent = true;
  }
  const double k = contact.stiffness, b = row.gap < 0 ? contact.damping : 0;
  const Vec3 turn = cross(r, n);
  row.unit = {n, turn};
  const Vec3 v_W = velocity_at(body.V_WC, r) - contact.velocity_W;
  row.push = -k * row.gap - b * dot(n, v_W);
  row.by_motion = {-k * n, -k * turn - b * cross(r, cross(n, body.V_WC.w))};
  if (row.is_bent && b > 0) {
    const Vec3 turned = -b * (row.bend * v_W);
    row.by_motion = row.by_motion + Twist{turned, cross(r, turned)};
  }
  row.by_twist = {-b * n, -b * turn};
  return row;
}

void add_row(const ContactRow& row, double push, BodyWrench& sum) {
  sum.F_W = sum.F_W + push * row.unit;
  add_outer(sum.by_motion, row.unit, row.by_motion);
  add_outer(sum.by_twist, row.unit, row.by_twist);
  if (!(push > 0)) return;
  const Mat3 lever = skew(row.lever_W);
  add_block(sum.by_motion, 3, 3, skew(push * row.unit.f) * lever);
  if (!row.is_bent) return;
  const Mat3 bend = push * row.bend, bend_by_angle = -1.0 * (bend * lever);
  add_block(sum.by_motion, 0, 0, bend);
  add_block(sum.by_motion, 0, 3, bend_by_angle);
  add_block(sum.by_motion, 3, 0, lever * bend);
  add_block(sum.by_motion, 3, 3, lever * bend_by_angle);
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
