// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/report.h"

#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <thread>

#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

template <typename T>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

bool is_count(double value) {
  return value == std::floor(value) && std::fabs(value) < 1e15;
}

/// The last column of the table: comparison with the peer, or whether the goal holds.
std::string verdict(const Row& row) {
  if (!row.peer.empty() && !row.peer_value) return row.peer + ": none";
  if (row.peer_value) {
    const double ratio = row.ratio().value_or(std::numeric_limits<double>::quiet_NaN());
    return formatted("%.2f", ratio) + " × " + readable(*row.peer_value, row.unit) + " of " +
           row.peer;
  }
  if (!row.holds) return "";
  std::string text = *row.holds ? "ok" : "MISSED";
  if (row.goal) text += " (goal " + readable(*row.goal, row.unit) + ")";
  return text;
}

}  // namespace

std::string readable(double value, const std::string& unit) {
  if (unit.empty()) return is_count(value) ? formatted("%.0f", value) : formatted("%.4g", value);
  if (unit != "s" && unit != "m" && unit != "J") {
    return (is_count(value) && std::fabs(value) >= 100 ? formatted("%.0f", value)
                                                       : formatted("%.4g", value)) +
           " " + unit;
  }
  struct Prefix {
    double scale;
    const char* name;
  };
  for (const Prefix& p : {Prefix{1, ""}, Prefix{1e-3, "m"}, Prefix{1e-6, "µ"}, Prefix{1e-9, "n"}}) {
    if (std::fabs(value) >= p.scale)
      return formatted("%.3g", value / p.scale) + " " + p.name + unit;
  }
  return value == 0 ? "0 " + unit : formatted("%.2e", value) + " " + unit;
}

void print_table(std::ostream& out, const std::vector<Row>& rows) {
  size_t metric_width = 0, value_width = 0;
  bool has_cases = false;
  for (const Row& row : rows) {
    has_cases |= row.case_name != rows[0].case_name;
    metric_width = std::max(metric_width, count_characters(row.metric));
    if (!row.note.empty()) continue;
    value_width = std::max(value_width, count_characters(readable(row.value, row.unit)));
  }
  const std::string* last_case = nullptr;
  for (const Row& row : rows) {
    const bool begins = last_case == nullptr || *last_case != row.case_name;
    if (has_cases && begins) out << row.case_name << '\n';
    last_case = &row.case_name;
    out << "  " << padded(row.metric, metric_width + 2);
    const std::string value = row.note.empty() ? readable(row.value, row.unit) : row.note;
    const std::string said = verdict(row);
    out << (said.empty() ? value : padded(value, value_width + 2) + said) << '\n';
  }
}

void print_json(std::ostream& out, const std::vector<Row>& rows) {
  Json all = Json::array();
  for (const Row& row : rows) {
    all.push_back({{"case", row.case_name},
                   {"metric", row.metric},
                   {"value", row.value},
                   {"unit", row.unit},
                   {"peer", row.peer.empty() ? Json(nullptr) : Json(row.peer)},
                   {"peer_value", json_or_null(row.peer_value)},
                   {"ratio", json_or_null(row.ratio())},
                   {"goal", json_or_null(row.goal)},
                   {"holds", json_or_null(row.holds)}});
    if (!row.note.empty()) all.back()["note"] = row.note;
  }
  out << json_lines(all);
}

bool all_hold(const std::vector<Row>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const Row& r) { return r.holds.value_or(true); });
}

Rows Rows::of(const std::string& case_name, bool are_judged) const {
  Rows other(case_name, are_judged);
  other.rows_ = rows_;
  return other;
}

Rows Rows::machine(const std::string& case_name) const {
  Rows rows = of(case_name);
  rows.note("machine", machine_line());
  return rows;
}

void Rows::add(const std::string& metric, Figure figure, const std::string& unit,
               const Goal& goal) {
  rows_->push_back({case_name_, metric, figure.value, unit, "", {}, {}, {}, one_line(figure.text)});
  if (!goal.value || !are_judged_) return;
  rows_->back().goal = goal.value;
  rows_->back().holds = goal.holds(figure.value, *goal.value);
}

void Rows::add(std::initializer_list<Line> lines) {
  for (const auto& [metric, figure, unit, goal] : lines) add(metric, figure, unit, goal);
}

void Rows::add_beside(const std::string& metric, double value, const std::string& unit,
                      const std::string& peer, std::optional<double> peer_value) {
  rows_->push_back({case_name_, metric, value, unit, peer, peer_value, {}, {}, ""});
}

void Rows::add(const std::string& metric, const Histogram& durations) {
  if (durations.count() == 0) return;
  add({{metric + " p50", 1e-9 * static_cast<double>(durations.percentile(50)), "s"},
       {metric + " p99", 1e-9 * static_cast<double>(durations.percentile(99)), "s"},
       {metric + " max", 1e-9 * static_cast<double>(durations.max()), "s"}});
}

void Rows::append(const std::vector<Row>& rows) {
  rows_->insert(rows_->end(), rows.begin(), rows.end());
}

std::string machine_line() {
  std::string cpu = "unknown processor";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    cpu = line.substr(std::min(line.size(), line.find(':') + 2));
    break;
  }
  utsname system{};
  uname(&system);
  double load = 0;
  getloadavg(&load, 1);
  return std::string("hapticd ") + version() + " on " + cpu + ", " +
         std::to_string(std::thread::hardware_concurrency()) + " cores, kernel " + system.release +
         ", load " + formatted("%.2f", load);
}

}  // namespace haptic
