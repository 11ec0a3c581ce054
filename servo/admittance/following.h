// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

/// The ways that an arm was commanded to go, tick by tick.
struct CommandedWays {
  static constexpr uint64_t kTicks = 512;  // 50 ms of the highest servo rate, and some
  struct Way {
    double moving = 0;   // [m]
    double turning = 0;  // [rad]
  };
  std::array<Way, kTicks> ways{};
  uint64_t count = 0;
};

void note_way(CommandedWays& commanded, const Pose& from, const Pose& to);

/// True if an arm that was last commanded to X_command_B goes where it is commanded: it is where it
/// was commanded to be at most 50 ms and three ticks ago, so it is no farther from the last command
/// than the commands have gone since; with 2 mm and 20 mrad for what it yields under its load.
bool is_following(const CommandedWays& commanded, const Pose& X_command_B, const Pose& X_BH,
                  double dt);

}  // namespace haptic
