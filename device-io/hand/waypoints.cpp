// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/waypoints.h"

#include <cmath>

#include "device-io/hand/portable_turn.h"
#include "proto/math/assert.h"

namespace haptic {

Intent along_waypoints(const IntentConfig& config, double t) {
  HAPTIC_ASSERT(config.n_waypoints > 0 && config.n_waypoints <= kMostWaypoints);
  double left = std::fmax(t, 0) - config.waypoints[0].rest;
  for (uint32_t i = 1; i < config.n_waypoints && left > 0; ++i) {
    const Waypoint& to = config.waypoints[i];
    if (left < to.time) {
      const Pose& from = config.waypoints[i - 1].X_BH;
      const IntentProgress progress = minimum_jerk(left / to.time, to.time);
      const Vec3 way = to.X_BH.p - from.p;
      const Vec3 turn = portable_rotation_vector(to.X_BH.q * conjugate(from.q));
      return {from.p + progress.s * way, progress.rate * way,
              portable_turn(progress.s * turn) * from.q, progress.rate * turn};
    }
    left -= to.time + to.rest;
    if (left <= 0) return {to.X_BH.p, {}, to.X_BH.q, {}};
  }
  const bool has_begun = left > 0;
  const Pose& rest = config.waypoints[has_begun ? config.n_waypoints - 1 : 0].X_BH;
  return {rest.p, {}, rest.q, {}};
}

}  // namespace haptic
