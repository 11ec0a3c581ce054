// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

namespace haptic {

/// Bounds the energy that somebody gives the hand, by a share of what it may be felt of.
///
///   level L [J]   W of each tick, the work on the hand, is added; a positive level leaks by 0.4 P
///                 each second; it falls no lower than −0.25 P · 1 s
///   share         1 up to half of the room R = 0.3 P · 1 s, then linearly to 0 at R
///   bound         no more than 0.95 P · 1 s in any second, and the work of one tick: from the
///                 lowest level to R, and what leaks meanwhile. P is max_power [W]
///
/// What the hand has put in is given back up to the lowest level, so that a spring may be pressed
/// and let go; more would be spent later as if it were its own. The share falls before the room
/// ends, so that nothing is cut in a step.
class EnergyBank {
 public:
  void note(double work, double dt, double max_power) {
    const double leak = std::min(kLeak * max_power * dt, std::max(level_, 0.0));
    level_ = std::max(level_ - leak + work, -kCredit * max_power);
  }
  double share(double max_power) const {
    const double room = kRoom * max_power;
    return room > 0 ? std::clamp(2 * (1 - level_ / room), 0.0, 1.0) : 0;
  }

 private:
  static constexpr double kRoom = 0.3, kLeak = 0.4, kCredit = 0.25;  // of P [s], [1], [s]
  double level_ = 0;
};

}  // namespace haptic
