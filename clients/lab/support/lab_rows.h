// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "clients/report/report.h"

/// Rows as only the laboratory has them.
namespace haptic {

/// A goal that applies only if `fair`.
inline std::optional<double> goal_if(bool fair, double goal) {
  return fair ? std::optional(goal) : std::nullopt;
}

/// Rows that begin with the machine that they were measured on.
inline Rows machine_rows(const std::string& case_name) {
  Rows rows(case_name);
  rows.note("machine", machine_line());
  return rows;
}

}  // namespace haptic
