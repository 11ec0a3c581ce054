// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/penalty_dynamics.h"

#include <algorithm>
#include <array>

#include "proto/math/assert.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

constexpr int kMostRounds = 10;  // of the active set

/// The inertia in W and the gyroscopic torque.
struct Spin {
  Mat3 inertia_W;
  Vec3 torque_W;  // −ω × I_W ω
  Mat3 by_spin;   // derivative by ω: [I ω]× − [ω]× I
};

Spin spin_of(const ToolBody& tool, const BodyMotion& body) {
  const Mat3 inertia = inertia_of(tool, body.X_WC.q);
  const Vec3& w = body.V_WC.w;
  const Vec3 momentum = inertia * w;
  return {inertia, -cross(w, momentum), skew(momentum) + -1.0 * (skew(w) * inertia)};
}

/// Solves [M − h D − h² K] Δu = h (f + h K u).
bool implicit_change(const ToolBody& tool, const BodyMotion& body, const BodyWrench& wrench,
                     double h, Twist& change) {
  const Spin spin = spin_of(tool, body);
  Mat6 D = wrench.by_twist;
  add_block(D, 3, 3, spin.by_spin);
  Mat6 A = mass_matrix(tool.mass, spin.inertia_W);
  A += -h * D;
  A += -(h * h) * wrench.by_motion;
  const Wrench f = wrench.F_W + Wrench{{}, spin.torque_W};
  return solve(A, h * (f + h * (wrench.by_motion * body.V_WC)), change);
}

/// With the contacts that push at the end of the step.
bool implicit_change(const ToolBody& tool, const BodyMotion& body, const BodyWrench& wrench,
                     std::span<const SoftContact> contacts, double h, Twist& change) {
  std::array<ContactRow, kMaxContacts> rows;
  std::array<bool, kMaxContacts> pushes{};
  const size_t n = std::min<size_t>(contacts.size(), rows.size());
  const auto push_after = [&](const ContactRow& row, const Twist& change_of_twist) {
    const Twist& u = body.V_WC;
    const Twist way{h * (u.v + change_of_twist.v), h * (u.w + change_of_twist.w)};
    return row.push + dot(row.by_motion, way) + dot(row.by_twist, change_of_twist);
  };
  for (size_t i = 0; i < n; ++i) {
    rows[i] = linearise(contacts[i], body);
    pushes[i] = push_after(rows[i], {}) > 0;
  }
  for (int round = 0; round < kMostRounds; ++round) {
    BodyWrench sum = wrench;
    for (size_t i = 0; i < n; ++i) {
      if (pushes[i]) add_row(rows[i], rows[i].push, sum);
    }
    if (!implicit_change(tool, body, sum, h, change)) return false;
    bool same = true;
    for (size_t i = 0; i < n; ++i) {
      const bool after = push_after(rows[i], change) > 0;
      // late rounds only remove contacts, so that two cannot alternate for ever
      const bool now = round < kMostRounds / 2 ? after : after && pushes[i];
      same &= now == pushes[i];
      pushes[i] = now;
    }
    if (same) break;
  }
  return true;
}

bool explicit_change(const ToolBody& tool, const BodyMotion& body, const BodyWrench& wrench,
                     std::span<const SoftContact> contacts, double h, Twist& change) {
  const Spin spin = spin_of(tool, body);
  Wrench f = wrench.F_W + Wrench{{}, spin.torque_W};
  f = f + soft_contact_wrench(contacts, body).F_W;
  return solve(mass_matrix(tool.mass, spin.inertia_W), h * f, change);
}

}  // namespace

PenaltyResult penalty_dynamics_step(const ToolBody& tool, const BodyMotion& body,
                                    const BodyWrench& wrench, std::span<const SoftContact> contacts,
                                    Integrator integrator, const PenaltyStep& step) {
  HAPTIC_ASSERT(step.dt > 0 && !(step.max_travel < 0));
  HAPTIC_ASSERT(tool.mass > 0);
  HAPTIC_ASSERT(contacts.size() <= kMaxContacts);
  const double h = step.dt;
  Twist change;
  const bool is_solved = integrator == Integrator::kImplicit
                             ? implicit_change(tool, body, wrench, contacts, h, change)
                             : explicit_change(tool, body, wrench, contacts, h, change);
  if (!is_solved) return {{body.X_WC, {}}, false, false};
  const Twist before = body.V_WC;
  Twist after{before.v + change.v, before.w + change.w};
  const Twist way = integrator == Integrator::kExplicit ? before : after;
  Twist motion{h * way.v, h * way.w};
  bool was_cut = false;
  if (step.max_travel > 0) {
    const LimitedMotion limited = limit_travel(motion, tool.radius, step.max_travel);
    was_cut = limited.was_cut;
    motion = limited.motion;
    if (was_cut) after = limit_travel(after, tool.radius, step.max_travel / h).motion;
  }
  return {{moved(body.X_WC, motion), after}, was_cut, true};
}

}  // namespace haptic
