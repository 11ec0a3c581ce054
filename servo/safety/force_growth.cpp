// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/force_growth.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

bool draw_within(const Vec3& held, double growth, Vec3& wanted) {
  const double squared = norm_squared(held);
  const double share = squared > 0 ? std::clamp(dot(wanted, held) / squared, 0.0, 1.0) : 0;
  const Vec3 nearest = share * held;
  const double beyond = norm(wanted - nearest);
  if (beyond <= growth) return false;
  wanted = nearest + growth / beyond * (wanted - nearest);
  return true;
}

}  // namespace

bool limit_growth(const Wrench& held, const WrenchGrowth& growth, Wrench& wanted) {
  HAPTIC_ASSERT(growth.force >= 0 && growth.torque >= 0);
  HAPTIC_ASSERT(is_finite(held) && is_finite(wanted));
  const double before = norm(wanted.f);
  const bool force_cut = draw_within(held.f, growth.force, wanted.f);
  if (force_cut) wanted.t *= norm(wanted.f) / before;
  const bool torque_cut = draw_within(held.t, growth.torque, wanted.t);
  return force_cut || torque_cut;
}

}  // namespace haptic
