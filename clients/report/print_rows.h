// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iostream>
#include <vector>

#include "clients/report/report.h"
#include "proto/config/command_line.h"

namespace haptic {

/// Prints the rows as a table or as JSON; throws ExitCode{1} if a goal is missed.
inline void print_judged(const std::vector<Row>& rows, bool json) {
  json ? print_json(std::cout, rows) : print_table(std::cout, rows);
  std::cout.flush();
  if (!all_hold(rows)) throw ExitCode{1};
}

}  // namespace haptic
