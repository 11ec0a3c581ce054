// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iostream>
#include <vector>

#include "clients/report/report.h"
#include "proto/config/command_line.h"

namespace haptic {

/// Prints them for people or as JSON and ends the command with exit code 1 where a goal is missed.
inline void print_judged(const std::vector<Row>& rows, bool json) {
  json ? print_json(std::cout, rows) : print_table(std::cout, rows);
  std::cout.flush();
  if (!all_hold(rows)) throw ExitCode{1};
}

}  // namespace haptic
