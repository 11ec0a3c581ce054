// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clients/report/report.h"
#include "proto/config/command_line.h"

namespace haptic {

/// What was measured: rows, and how they are printed for people.
struct Report {
  Report(std::vector<Row> measured, std::function<void(std::ostream&)> for_people = {})
      : rows(std::move(measured)), print(std::move(for_people)) {}

  std::vector<Row> rows;
  std::function<void(std::ostream&)> print;  // empty: as a table
};

/// Measures, once the options are read.
using Measured = std::function<Report()>;

/// Adds a measurement's own options to its command and returns what measures with them.
using Prepare = Measured(Command& command);

/// A row of `hapt bench` or of `hapt eval`.
struct Measurement {
  std::string name;  // '_' is typed as '-'
  const char* help;
  Prepare* prepare;
};

/// Makes a command of the measurement: it prints the rows as a table, or as JSON with --json, and
/// ends with exit code 1 where one misses its goal.
void measure_by(Command& command, Prepare* prepare);

/// A subcommand for each row.
void add_measurements(Command& command, const std::string& full_name,
                      std::span<const Measurement> table);

/// Option --rounds; the present value is the default.
Option add_rounds(Command& command, int& rounds, const std::string& help);

}  // namespace haptic
