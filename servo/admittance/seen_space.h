// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/wire/age.h"
#include "proto/wire/wire.h"

namespace haptic {

inline constexpr double kLeastSeen = 25e-6;  // what a set that is not complete still covers [m]

/// How fast the tool was in the ticks that contact may still answer [m/s], which is what its
/// look-ahead goes by (proto/wire/look_ahead.h).
struct SeenSpace {
  static constexpr uint64_t kTicks = 256;
  struct Asked {
    uint64_t tick = 0;
    double speed = 0;
    bool known = false;
  };
  std::array<Asked, kTicks> asked{};
};

void note_asked(SeenSpace& seen, uint64_t tick, double speed);

/// How far from the set's verified pose everything that the tool could meet is among its contacts
/// [m]; 0: nothing is known of the tick that it answers, or it is not complete.
double seen_radius(const SeenSpace& seen, const ContactSet& set, const Age& age, bool is_body,
                   double dt);

/// The tool's motion from X_WT, shortened such that it goes at most half of the way that is left to
/// the rim of what was seen: what nobody has looked at counts as a wall, and the tool slows down
/// before it. `rim` is the distance of the tool's farthest point from its origin [m].
Pose kept_within(const Pose& X_WG, double radius, double rim, const Pose& from, const Pose& to);

}  // namespace haptic
