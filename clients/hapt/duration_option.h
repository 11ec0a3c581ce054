// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/config/command_line.h"

namespace haptic {

/// An option for a duration, above zero and at most a month [s]; a bare number is in seconds.
inline Option add_duration(Command& command, const std::string& name, double& seconds,
                           const std::string& help) {
  constexpr double kMonth = 31 * 86400.0;
  return command.quantity(name, seconds, Dimension::kTime, {0, kMonth, true},
                          help + ", as \"20 s\"; a number alone: seconds", "s");
}

}  // namespace haptic
