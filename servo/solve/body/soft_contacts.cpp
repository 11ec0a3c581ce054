// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_contacts.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kMostOfSprings = 0.5;  // largest pull of the rest, as a share of the springs' push

double push_of(const SoftContact& contact, const Pose& X_WC) {
  return contact.stiffness * std::max(-gap_of(contact, X_WC), 0.0);
}

/// The map K about a point displaced by −arm, for both wrench and motion.
Mat6 about_centre(const Mat6& K, const Vec3& arm) {
  // motion of the old point from that of the new one, and the wrench back
  Mat6 to_old, to_new;
  for (size_t i = 0; i < 6; ++i) to_old(i, i) = to_new(i, i) = 1;
  add_block(to_old, 0, 3, -1.0 * skew(arm));
  add_block(to_new, 3, 0, skew(arm));
  return to_new * (K * to_old);
}

SoftContact spring_of(const CarriedContact& c, const ToolBody& tool, const SoftCarry& carry) {
  const double weight = carry.soft_weight(c.object) * c.given;
  SoftContact spring{c, c.tool_point_T - tool.centre_T, weight * carry.damping};
  spring.stiffness = weight * (c.stiffness > 0 ? c.stiffness : carry.stiffness);
  return spring;
}

/// The way of the object that the linearised wrench is about, since the set; none: it is not there.
std::optional<Pose> way_of_wrench(const ContactSet& set, const SoftCarry& carry) {
  const uint32_t object = set.wrench_object;
  if (object >= std::min(set.objects.size(), carry.X_WO.size())) return {};
  return carry.X_WO[object] * inverse(set.objects[object].X_WO);
}

/// The linearised wrench about C, moved with its object by `moved_by`, minus the springs.
void carry_rest(const ContactSet& set, const ToolBody& tool, const SoftCarry& carry,
                const Pose& moved_by, SoftContacts& out) {
  const uint32_t object = set.wrench_object;
  out.rest_object = object;
  out.X_WC0 = moved_by * motion_of_centre(tool, {set.X_WT, {}}).X_WC;
  out.trust_radius = set.trust_radius;
  const Mat3 R = to_matrix(moved_by.q);
  const Vec3 arm_W = -rotate(out.X_WC0.q, tool.centre_T);
  Mat6 K;
  K.a = set.K;
  out.K_rest = carry.soft_weight(object) * about_centre(rotated(R, K), arm_W);
  const Wrench F{R * set.F0_W.f, R * set.F0_W.t};
  out.F_rest_W = carry.soft_weight(object) * shift(F, arm_W);
  for (size_t i = 0; i < out.size; ++i) {
    const SoftContact& c = out.contacts[i];
    const double push = push_of(c, out.X_WC0);
    if (c.object != object || !(push > 0)) continue;
    const Vec3 turn = cross(rotate(out.X_WC0.q, c.tool_point_C), c.normal_W);
    const Wrench unit{c.normal_W, turn};
    out.F_rest_W = out.F_rest_W + -push * unit;
    add_outer(out.K_rest, unit, {c.stiffness * c.normal_W, c.stiffness * turn});
    out.push0 += push;
  }
  out.has_rest =
      out.push0 > 0 && is_finite(out.F_rest_W) && is_finite(out.X_WC0) && all_finite(out.K_rest.a);
}

void carry_brake(const ContactSet& set, const ToolBody& tool, const SoftCarry& carry,
                 const Pose& moved_by, SoftContacts& out) {
  const uint32_t object = set.wrench_object;
  Mat6 B;
  B.a = set.B;
  if (B == Mat6{}) return;
  const Vec3 arm_W = -rotate((moved_by * set.X_WT).q, tool.centre_T);
  out.B = carry.soft_weight(object) * about_centre(rotated(to_matrix(moved_by.q), B), arm_W);
  out.X_WO_brake = carry.X_WO[object];
  out.V_WO_brake = carry.V_WO[object];
  out.has_brake = all_finite(out.B.a);
}

/// F_rest + K_rest δ.
BodyWrench rest_at(const SoftContacts& contacts, const ToolBody& tool, const Pose& X_WC) {
  const Twist way = way_between(contacts.X_WC0, X_WC);
  const LimitedMotion limited = limit_travel(way, tool.radius, contacts.trust_radius);
  const Wrench change = contacts.K_rest * limited.motion;
  BodyWrench rest;
  rest.F_W = contacts.F_rest_W + change;
  if (!limited.was_cut) rest.by_motion = contacts.K_rest;
  return rest;
}

}  // namespace

SoftContacts carry_soft_contacts(const ContactSet& set, const ToolBody& tool,
                                 const SoftCarry& carry) {
  SoftContacts out;
  if (!(carry.weight > 0)) return out;
  HAPTIC_ASSERT(carry.stiffness >= 0 && carry.damping >= 0);
  const CarriedContacts carried = carry_contacts(set, carry);
  out.finite = carried.finite;
  out.size = carried.size;
  for (size_t i = 0; i < out.size; ++i) {
    out.contacts[i] = spring_of(carried.contacts[i], tool, carry);
    if (carried.contacts[i].object == set.wrench_object) out.n_springs = i + 1;
  }
  const std::optional<Pose> moved_by = way_of_wrench(set, carry);
  if (set.trust_radius > 0 && moved_by) {
    carry_rest(set, tool, carry, *moved_by, out);
    carry_brake(set, tool, carry, *moved_by, out);
  }
  return out;
}

void fade_past_extent(const Pose& X_WC, SoftContacts& contacts) {
  for (SoftContact& c : contacts.view()) {
    const Vec3 tool_W = X_WC * c.tool_point_C;
    const double weight = weight_at(c, 1, {&tool_W, 1});
    c.stiffness *= weight;
    c.damping *= weight;
  }
}

BodyWrench rest_wrench(const SoftContacts& contacts, const ToolBody& tool, const Pose& X_WC,
                       const BodyMotion& end) {
  BodyWrench rest;
  if (!contacts.has_rest) return rest;
  HAPTIC_ASSERT(contacts.push0 > 0 && contacts.n_springs <= contacts.size);
  double push = 0;
  Vec3 springs_W;
  for (size_t i = 0; i < contacts.n_springs; ++i) {
    const std::optional<ContactRow> row = pushing_row(contacts.contacts[i], end);
    if (!row) continue;
    push += row->push;
    springs_W += row->push * contacts.contacts[i].normal_W;
  }
  const double share = std::min(push / contacts.push0, 1.0);
  if (!(share > 0)) return rest;
  const Vec3 force_end_W = rest_at(contacts, tool, end.X_WC).F_W.f;
  double force_share = share;
  for (size_t i = 0; i < contacts.n_springs; ++i) {
    const double pull = -dot(force_end_W, contacts.contacts[i].shading_W);
    const double most = kMostOfSprings * dot(springs_W, contacts.contacts[i].shading_W);
    if (most > 0 && force_share * pull > most) force_share = most / pull;
  }
  rest = rest_at(contacts, tool, X_WC);
  rest.F_W = {force_share * rest.F_W.f, share * rest.F_W.t};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) rest.by_motion(i, j) *= i < 3 ? force_share : share;
  }
  return rest;
}

BodyWrench brake_wrench(const SoftContacts& contacts, const BodyMotion& body) {
  BodyWrench brake;
  if (!contacts.has_brake) return brake;
  const Twist& V_WO = contacts.V_WO_brake;
  const Vec3 v_O_W = velocity_at(V_WO, body.X_WC.p - contacts.X_WO_brake.p);
  const Wrench F = contacts.B * Twist{body.V_WC.v - v_O_W, body.V_WC.w - V_WO.w};
  for (size_t i = 0; i < contacts.n_springs; ++i) {
    if (dot(F.f, contacts.contacts[i].shading_W) < 0) return brake;
  }
  brake.F_W = F;
  brake.by_twist = contacts.B;
  return brake;
}

}  // namespace haptic
