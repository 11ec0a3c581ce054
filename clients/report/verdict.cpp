// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "clients/report/summary.h"

namespace haptic {
namespace {

constexpr std::array<std::string_view, 7> kFirst{
    "real time",         kContactShare, kFirstTouch, "late ticks (grid points skipped)",
    "wake lateness p99", "log",         "plot"};

std::string missed_goals(const std::vector<Row>& rows) {
  std::string missed;
  for (const Row& row : rows) {
    if (row.holds.value_or(true)) continue;
    missed += (missed.empty() ? "" : ", ") + row.metric + " " + readable(row.value, row.unit);
    if (row.goal) missed += " (goal " + readable(*row.goal, row.unit) + ")";
  }
  return missed;
}

double figure(const std::vector<Row>& rows, std::string_view metric) {
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.metric == metric; });
  return row != rows.end() ? row->value : 0;
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
  std::string behind;
  for (const BehindRow& b : kBehind) {
    const double share = figure(rows, b.metric);
    if (share > 0) behind += ", " + std::string(b.words) + " for " + readable(share, "%");
  }
  return one_line("passed: " + readable(seconds, "s") + " with " + shown + ", " +
                  std::to_string(std::lround(figure(rows, kContactShare))) + " % in contact" +
                  behind + "; next: " + next);
}

}  // namespace haptic
