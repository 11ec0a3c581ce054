// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <iostream>
#include <memory>

#include "clients/hapt/options.h"

namespace haptic {

void measure_by(Command command, Prepare* prepare, const std::string& example) {
  const auto json = std::make_shared<bool>(false);
  const Measured measured = prepare(command);
  add_json(command, *json);
  command.example(example);
  command.action([json, measured] {
    Report report;
    measured(report);
    const std::vector<Row>& rows = report.rows.rows();
    if (*json) {
      print_json(std::cout, rows);
    } else {
      report.print ? report.print(std::cout) : print_table(std::cout, rows);
    }
    std::cout.flush();
    if (!all_hold(rows)) throw ExitCode{1};
  });
}

void add_measurements(Command& command, const std::string& full_name,
                      std::span<const Measurement> table) {
  for (const Measurement& row : table) {
    std::string name = row.name;
    std::ranges::replace(name, '_', '-');
    measure_by(command.subcommand(name, row.help), row.prepare, full_name + " " + name + " --json");
  }
}

void add_counts(Command& command, std::initializer_list<Count> counts) {
  for (const Count& count : counts) {
    const auto add = [&](auto* number) {
      command.option(count.name, *number, count.help).range(count.low, count.high).show_default();
    };
    std::visit(add, count.value);
  }
}

}  // namespace haptic
