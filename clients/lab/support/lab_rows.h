// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/report/report.h"

/// Rows as only the laboratory has them.
namespace haptic {

/// A goal that applies only if `fair`.
inline std::optional<double> goal_if(bool fair, double goal) {
  return fair ? std::optional(goal) : std::nullopt;
}

}  // namespace haptic
