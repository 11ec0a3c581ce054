// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace haptic {

/// One figure: the row every `hapt eval` and `hapt bench` prints. Empty optionals are JSON null.
struct Row {
  std::string case_name;
  std::string metric;
  double value = 0;
  std::string unit;
  std::string peer;  // empty: none
  std::optional<double> peer_value;
  std::optional<double> goal;
  std::optional<bool> holds;

  std::optional<double> ratio() const {
    if (!peer_value || *peer_value == 0) return std::nullopt;
    return value / *peer_value;
  }
};

/// Machine, load average and version: what a figure is worth nothing without.
struct MachineInfo {
  std::string cpu, kernel, version;
  unsigned cores = 0;
  double load = 0;  // 1-minute average
};
MachineInfo machine_info();

/// A table for people: metric, value with a readable unit prefix, goal where there is one.
void print_table(std::ostream& out, const std::vector<Row>& rows);

/// One JSON array of objects {case, metric, value, unit, peer, peer_value, ratio, goal, holds}.
void print_json(std::ostream& out, const std::vector<Row>& rows);

/// False when any row misses its goal.
bool all_hold(const std::vector<Row>& rows);

/// "12.3 µs", "4.10 N", "0.017 mm": three significant digits and an SI prefix for s, m and J; other
/// units as they are.
std::string readable(double value, const std::string& unit);

}  // namespace haptic
