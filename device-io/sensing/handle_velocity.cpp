// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/sensing/handle_velocity.h"

#include <numbers>

#include "proto/math/assert.h"

namespace haptic {

void low_pass_velocity(const Pose& before_B, const Pose& after_B, double dt, double cutoff,
                       Twist& V_B) {
  HAPTIC_ASSERT(dt > 0 && cutoff > 0);
  const double share = dt / (dt + 1 / (2 * std::numbers::pi * cutoff));
  const Vec3 raw_v_B = (after_B.p - before_B.p) / dt;
  const Vec3 raw_w_B = to_rotation_vector(after_B.q * conjugate(before_B.q)) / dt;
  V_B.v += share * (raw_v_B - V_B.v);
  V_B.w += share * (raw_w_B - V_B.w);
}

}  // namespace haptic
