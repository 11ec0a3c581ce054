// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

#include "clients/library/histogram.h"
#include "proto/os/message.h"

namespace haptic {

/// One figure, as printed by every `hapt eval` and `hapt bench`. NaN and empty optionals become
/// JSON null.
struct Row {
  std::string case_name;
  std::string metric;
  double value = 0;
  std::string unit;
  std::string peer;  // empty: none
  std::optional<double> peer_value;
  std::optional<double> goal;
  std::optional<bool> holds;
  std::string note;  // text instead of a figure: the machine, the name of the log

  std::optional<double> ratio() const {
    if (!peer_value || *peer_value == 0) return std::nullopt;
    return value / *peer_value;
  }
};

/// A count or a measurement, or text in place of one.
struct Figure {
  double value;
  std::string text = {};
  template <class Number>
  requires std::is_arithmetic_v<Number> Figure(Number number)
      : value(static_cast<double>(number)) {}
  Figure(std::string words)
      : value(std::numeric_limits<double>::quiet_NaN()), text(std::move(words)) {}
  Figure(const char* words) : Figure(std::string(words)) {}
};

/// A goal of a figure, and how it is held to it. Without a value the figure stands alone.
struct Goal {
  std::optional<double> value = {};
  bool (*holds)(double figure, double goal) = nullptr;
};
inline Goal at_most(std::optional<double> goal) {
  return {goal, [](double figure, double most) { return figure <= most; }};
}
inline Goal at_least(std::optional<double> goal) {
  return {goal, [](double figure, double least) { return figure >= least; }};
}
/// Held where something else says so.
inline Goal given(std::optional<double> goal, bool holds) {
  if (holds) return {goal, [](double, double) { return true; }};
  return {goal, [](double, double) { return false; }};
}
/// The goal is zero.
inline const Goal kMustBeZero{0, [](double figure, double) { return figure == 0; }};

/// A line of a table of figures.
struct Line {
  std::string metric;
  Figure figure;
  std::string unit = {};
  Goal goal = {};
};

/// Adds rows of one case to a list, which its copies and other cases of the list share.
class Rows {
 public:
  /// Begins a list. Without `are_judged` goals are left out.
  explicit Rows(const std::string& case_name = "", bool are_judged = true)
      : case_name_(one_line(case_name)), are_judged_(are_judged) {}
  /// Another case, whose rows go to the same list.
  Rows of(const std::string& case_name, bool are_judged = true) const;
  /// Another case, whose first row is machine_line().
  Rows machine(const std::string& case_name) const;

  void add(const std::string& metric, Figure figure, const std::string& unit = "",
           const Goal& goal = {});
  void add(std::initializer_list<Line> lines);
  /// A figure compared with that of a peer in the same run; without a peer, `peer_value` is empty.
  void add_beside(const std::string& metric, double value, const std::string& unit,
                  const std::string& peer, std::optional<double> peer_value);
  /// p50, p99 and max of durations [ns] in seconds; nothing if there are none.
  void add(const std::string& metric, const Histogram& durations);
  void note(const std::string& metric, const std::string& text) { add(metric, text); }
  void append(const std::vector<Row>& rows);
  /// The whole list.
  const std::vector<Row>& rows() const { return *rows_; }

 private:
  std::string case_name_;
  bool are_judged_;
  std::shared_ptr<std::vector<Row>> rows_ = std::make_shared<std::vector<Row>>();
};

/// Version, processor, kernel and load: needed to interpret any figure.
std::string machine_line();

/// A table for people: metric, value with a readable unit prefix, goal or peer. With several cases
/// the name of each stands above its rows.
void print_table(std::ostream& out, const std::vector<Row>& rows);

/// One JSON array of objects {case, metric, value, unit, peer, peer_value, ratio, goal, holds};
/// notes also have the key `note`.
void print_json(std::ostream& out, const std::vector<Row>& rows);

/// False if any row misses its goal.
bool all_hold(const std::vector<Row>& rows);

/// "12.3 µs", "4.10 N", "0.017 mm": three significant digits and an SI prefix for s, m and J; other
/// units unchanged.
std::string readable(double value, const std::string& unit);

}  // namespace haptic
