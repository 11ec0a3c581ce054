// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/admittance/following.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "servo/safety/safety.h"

namespace haptic {
namespace {

constexpr double kMostDelay =
    0.05;  // of an arm that a hand could still lead (config_device.cpp) [s]
// every motion takes a tick, a measured pose may be a tick old, and a command late by one
constexpr double kMoreTicks = 3;

}  // namespace

void note_way(CommandedWays& commanded, const Pose& from, const Pose& to) {
  const Twist way = way_between(from, to);
  commanded.ways[commanded.count % CommandedWays::kTicks] = {norm(way.v), norm(way.w)};
  ++commanded.count;
}

bool is_following(const CommandedWays& commanded, const Pose& X_command_B, const Pose& X_BH,
                  double dt) {
  HAPTIC_ASSERT(dt > 0);
  const double ticks = std::ceil(kMostDelay / dt) + kMoreTicks;
  const uint64_t known = std::min(commanded.count, CommandedWays::kTicks);
  const auto n = static_cast<uint64_t>(std::min(ticks, static_cast<double>(known)));
  CommandedWays::Way most{kJumpWay, kJumpTurn};
  for (uint64_t i = 1; i <= n; ++i) {
    const CommandedWays::Way& way = commanded.ways[(commanded.count - i) % CommandedWays::kTicks];
    most.moving += way.moving;
    most.turning += way.turning;
  }
  const Twist left = way_between(X_BH, X_command_B);
  return norm(left.v) <= most.moving && norm(left.w) <= most.turning;
}

}  // namespace haptic
