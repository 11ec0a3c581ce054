// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "clients/report/summary.h"

namespace haptic {
namespace {

constexpr std::array<std::string_view, 8> kFirst{
    "real time",         kContactShare, kFirstTouch, "late ticks (grid points skipped)",
    "wake lateness p99", kGone,         "log",       "plot"};

std::string missed_goals(const std::vector<Row>& rows) {
  std::string missed;
  for (const Row& row : rows) {
    if (row.holds.value_or(true)) continue;
    missed += (missed.empty() ? "" : ", ") + row.metric + " " + readable(row.value, row.unit);
    if (row.goal) missed += " (goal " + readable(*row.goal, row.unit) + ")";
  }
  return missed;
}

/// The row of a metric; an empty one where there is none.
Row find_row(const std::vector<Row>& rows, std::string_view metric) {
  const auto row = std::ranges::find(rows, metric, &Row::metric);
  return row != rows.end() ? *row : Row{};
}

}  // namespace

std::vector<Row> brief(const std::vector<Row>& rows) {
  std::vector<Row> kept;
  for (const Row& row : rows) {
    const bool is_first =
        std::find(kFirst.begin(), kFirst.end(), row.metric) != kFirst.end() ||
        std::ranges::any_of(kBehind, [&](const BehindRow& b) { return b.metric == row.metric; });
    if (row.holds || is_first) kept.push_back(row);
    // why is a long story
    if (row.metric == "real time") kept.back().note = row.note.substr(0, row.note.find(':'));
  }
  return kept;
}

std::string verdict(const std::vector<Row>& rows, const std::string& shown, double seconds,
                    const std::string& trouble, const std::string& next) {
  if (!trouble.empty()) return one_line("FAILED: " + trouble);
  if (!all_hold(rows)) {
    return one_line("FAILED: " + missed_goals(rows) + "; --report prints every figure");
  }
  std::string troubles;
  for (const BehindRow& b : kBehind) {
    const double share = find_row(rows, b.metric).value;
    if (share > 0) troubles += ", " + std::string(b.past) + " for " + readable(share, "%");
  }
  if (const std::string gone = find_row(rows, kGone).note; !gone.empty()) troubles += ", " + gone;
  return one_line("passed: " + readable(seconds, "s") + " with " + shown + ", " +
                  std::to_string(std::lround(find_row(rows, kContactShare).value)) +
                  " % in contact" + troubles + "; next: " + next);
}

}  // namespace haptic
