// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/spacemouse/deflection.h"

#include <algorithm>
#include <cmath>

#include "device-io/sensing/saturate.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

double share_of(int16_t count, const RateDeviceConfig& config) {
  const double d = std::clamp(count / config.full_scale, -1.0, 1.0);
  const double beyond = std::max(0.0, std::fabs(d) - config.dead_band);
  return std::copysign(beyond / (1 - config.dead_band), d);
}

/// From the knob's axes to those of B: a quarter turn about x.
Vec3 in_base(const Vec3& raw) {
  return {raw.x, -raw.z, raw.y};
}

}  // namespace

Twist commanded_velocity(const SpaceMouseInput& input, const RateDeviceConfig& config) noexcept {
  HAPTIC_ASSERT(config.full_scale > 0 && config.dead_band >= 0 && config.dead_band < 1);
  Vec3 moving, turning;
  for (int i = 0; i < 3; ++i) {
    moving[i] = share_of(input.axes[static_cast<size_t>(i)], config);
    turning[i] = share_of(input.axes[static_cast<size_t>(i) + 3], config);
  }
  return {config.speed * in_base(moving), config.turn_rate * in_base(turning)};
}

Pose moved_within(const Pose& X_BH, const Twist& V_BH, double dt, const HandleRange& range) {
  HAPTIC_ASSERT(dt >= 0 && range.radius >= 0 && range.turn >= 0);
  Pose to{X_BH.p + dt * V_BH.v, normalized(from_rotation_vector(dt * V_BH.w) * X_BH.q)};
  if (range.radius > 0) {
    Vec3 way_B = to.p - range.centre_B;
    saturate(way_B, range.radius);
    to.p = range.centre_B + way_B;
  }
  if (range.turn > 0) {
    Vec3 away_B = to_rotation_vector(to.q * conjugate(range.rest_B));
    saturate(away_B, range.turn);
    to.q = normalized(from_rotation_vector(away_B) * range.rest_B);
  }
  return to;
}

}  // namespace haptic
