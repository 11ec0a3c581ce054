// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "clients/report/report.h"
#include "proto/config/command_line.h"

namespace haptic {

/// A goal that applies only if `fair`.
inline std::optional<double> goal_if(bool fair, double goal) {
  return fair ? std::optional(goal) : std::nullopt;
}

/// The rows that a measurement fills in; `print` shows them to people, and is empty where a table
/// does.
struct Report {
  Rows rows;
  std::function<void(std::ostream&)> print = {};
};

/// Measures, once the options are read.
using Measured = std::function<void(Report&)>;

/// Measures by a function of these options that fills in rows.
template <class Options>
Measured measured(void (*measure)(const Options&, const Rows&), std::shared_ptr<Options> options) {
  return [measure, options](Report& report) { measure(*options, report.rows); };
}

/// Adds a measurement's own options to its command and returns what measures with them.
using Prepare = Measured(Command& command);

/// A row of `hapt bench` or of `hapt eval`.
struct Measurement {
  std::string name;  // '_' is typed as '-'
  const char* help;
  Prepare* prepare;
};

/// Makes a command of the measurement: it prints the rows as a table, or as JSON with --json, and
/// ends with exit code 1 where one misses its goal. Its help shows the example.
void measure_by(Command command, Prepare* prepare, const std::string& example);

/// A subcommand for each row.
void add_measurements(Command& command, const std::string& full_name,
                      std::span<const Measurement> table);

/// An option that counts something within these limits; its present value is the default.
struct Count {
  std::string name;
  std::variant<int*, uint32_t*, uint64_t*> value;
  std::string help;
  int64_t low, high;
};
void add_counts(Command& command, std::initializer_list<Count> counts);
/// Option --rounds, of up to a thousand.
inline Count rounds_of(int& rounds, const std::string& help) {
  return {"--rounds", &rounds, help, 1, 1000};
}

}  // namespace haptic
