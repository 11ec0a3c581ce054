// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance/seen_space.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/look_ahead.h"

namespace haptic {
namespace {

constexpr double kShare = 0.5;  // of the way that is left, which one tick may go

}  // namespace

void note_asked(SeenSpace& seen, uint64_t tick, double speed) {
  HAPTIC_ASSERT(speed >= 0);
  seen.asked[tick % SeenSpace::kTicks] = {tick, speed, true};
}

double seen_radius(const SeenSpace& seen, const ContactSet& set, const Age& age, bool is_body,
                   double dt) {
  HAPTIC_ASSERT(dt > 0);
  const SeenSpace::Asked& asked = seen.asked[set.answers_tick % SeenSpace::kTicks];
  if (!asked.known || asked.tick != set.answers_tick) return 0;
  if ((set.flags & kContactNoFreePose) != 0) return 0;
  if ((set.flags & kContactTruncated) != 0) return kLeastSeen;
  const double period = std::max(1e-9 * static_cast<double>(age.median_ns), dt);
  const double reach = look_ahead_reach(asked.speed, period, dt, is_body, true);
  // contact looks around the place where the tool would be a tick or two later
  return std::max(reach - 2 * dt * asked.speed, 0.0);
}

Pose kept_within(const Pose& X_WG, double radius, double rim, const Pose& from, const Pose& to) {
  HAPTIC_ASSERT(radius >= 0 && rim >= 0);
  const Twist way = way_between(from, to);
  const double length = largest_travel(way, rim);
  const double left = radius - largest_travel(way_between(X_WG, from), rim);
  const double most = left > 0 ? kShare * left : 0;
  return length > most ? moved(from, most / length * way) : to;
}

}  // namespace haptic
