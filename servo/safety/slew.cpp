// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/slew.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// What is left of a wanted vector whose way from the segment between zero and `held` is bounded.
Mixture drawn_within(const Vec3& held, double growth, const Vec3& wanted) {
  const double squared = norm_squared(held);
  const double share = squared > 0 ? std::clamp(dot(wanted, held) / squared, 0.0, 1.0) : 0;
  const double beyond = norm(wanted - share * held);
  if (beyond <= growth) return {};
  const double kept = growth / beyond;
  return {(1 - kept) * share, kept};
}

}  // namespace

SlewLimit limit_slew(const Wrench& held, const WrenchGrowth& growth, const Wrench& wanted) {
  HAPTIC_ASSERT(growth.force >= 0 && growth.torque >= 0);
  HAPTIC_ASSERT(is_finite(held) && is_finite(wanted));
  SlewLimit limit;
  limit.force = drawn_within(held.f, growth.force, wanted.f);
  double with_force = 1;
  if (limit.force.wanted < 1) {
    limit.cut = true;
    with_force = norm(limit.force.of(held.f, wanted.f)) / norm(wanted.f);
  }
  limit.torque = drawn_within(held.t, growth.torque, with_force * wanted.t);
  limit.cut = limit.cut || limit.torque.wanted < 1;
  limit.torque.wanted *= with_force;
  return limit;
}

}  // namespace haptic
