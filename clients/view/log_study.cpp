// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/log_study.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "clients/view/web/http_rules.h"
#include "proto/log/csv.h"
#include "proto/os/json.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPieceTime = 20'000'000;  // [ns] of reading, then others have their turn
constexpr size_t kPieceChunks = 8;          // read in a piece: two seconds of a recording
constexpr double kMostSteps = 4000;         // of an overview: the widest screen
constexpr double kExactSeconds = 20;        // spans up to this are read frame by frame
constexpr uint64_t kMostRows = 120'000;     // of a table: two minutes, a hundred megabytes

constexpr std::array<const char*, kNumPlotted> kNames{
    "force_x",  "force_y", "force_z", "force",     "torque_x",    "torque_y",
    "torque_z", "torque",  "depth",   "wake_late", "contact_rate"};

Json column_json(const std::string& name, const std::vector<LogStep>& steps) {
  Json column{{"name", name}};
  for (size_t i = 0; i < kNumPlotted; ++i) {
    Json low = Json::array(), high = Json::array();
    for (const LogStep& step : steps) {
      low.push_back(step.frames > 0 ? Json(step.low[i]) : Json(nullptr));
      high.push_back(step.frames > 0 ? Json(step.high[i]) : Json(nullptr));
    }
    column[kNames[i]] = {{"min", std::move(low)}, {"max", std::move(high)}};
  }
  return column;
}

}  // namespace

LogStudy::LogStudy(const std::string& path, const Quat& q_WB)
    : index_(path), survey_(index_, q_WB), q_WB_(q_WB) {}

LogStudy::Piece LogStudy::advance() {
  Piece piece;
  index_.refresh();
  const double before = survey_.share();
  const int64_t end = now_ns() + kPieceTime;
  do {
    piece.has_more = survey_.advance(kPieceChunks);
  } while (piece.has_more && now_ns() < end);
  const auto first = survey_.marks().begin() + static_cast<std::ptrdiff_t>(n_told_);
  piece.marks.assign(first, survey_.marks().end());
  n_told_ = survey_.marks().size();
  piece.is_news = before < 1;
  return piece;
}

WebAnswer LogStudy::overview(std::string_view query) {
  const auto from = number_in(query, "from"), to = number_in(query, "to");
  const auto columns = number_in(query, "columns");
  // also false for NaN
  if (!from || !to || !columns || !(*to > *from && *to - *from < 1e9) ||
      !(std::fabs(*from) < 1e9) || !(*columns >= 1 && *columns <= kMostSteps)) {
    return text_answer(400,
                       "ask as /overview.json?from=SECONDS&to=SECONDS&columns=N, N at most 4000");
  }
  const auto n = static_cast<size_t>(*columns);
  Json times = Json::array();
  for (size_t k = 0; k < n; ++k) {
    times.push_back(*from + (*to - *from) * static_cast<double>(k) / static_cast<double>(n));
  }
  Json all{{"from", *from}, {"to", *to}, {"time", std::move(times)}, {"columns", Json::array()}};
  for (size_t column = 0; column < index_.columns().size(); ++column) {
    const bool is_short = *to - *from <= kExactSeconds;
    const auto steps =
        is_short ? exact_steps(*from, *to, n, column) : steps_of(*from, *to, n, column);
    all["columns"].push_back(column_json(index_.columns()[column].name, steps));
  }
  return {200, "application/json", shared_text(json_compact(all))};
}

/// Out of what the survey has read.
std::vector<LogStep> LogStudy::steps_of(double from, double to, size_t n, size_t column) {
  std::vector<LogStep> steps(n);
  const double each = (to - from) / static_cast<double>(n);
  const double begin = 1e-9 * static_cast<double>(index_.time_of(index_.first_tick()));
  const auto tick = [&](double time) { return index_.tick_of(std::llround(1e9 * time)); };
  for (size_t k = 0; k < n; ++k) {
    const double at = from + each * static_cast<double>(k);
    if (at + each < begin) continue;
    const uint64_t first = tick(at), last = std::max(first + 1, tick(at + each)) - 1;
    if (first <= index_.last_tick()) steps[k] = survey_.overview(first, last, 1, column)[0];
  }
  return steps;
}

std::vector<LogStep> LogStudy::exact_steps(double from, double to, size_t n, size_t column) {
  std::vector<LogStep> steps(n);
  PlottedOf plotted(q_WB_);
  const int64_t begin = std::llround(1e9 * from), end = std::llround(1e9 * to);
  const int64_t span = std::max<int64_t>(end - begin, 1);
  index_.for_each_frame(
      index_.tick_of(begin), index_.tick_of(end), column, [&](const ServoFrame& frame) {
        const auto values = plotted(frame);
        const int64_t after = frame.t_ns - begin;
        if (after < 0 || after >= span) return;
        const auto at = static_cast<size_t>(after * static_cast<int64_t>(n) / span);
        steps[at].add({0, 0, 1, values, values});
      });
  return steps;
}

WebAnswer LogStudy::table(std::string_view query) {
  const auto from = number_in(query, "from"), to = number_in(query, "to");
  const double column = number_in(query, "column").value_or(0);
  constexpr double kMost = 9007199254740992;  // 2⁵³
  if (!from || !to || !(*from >= 0 && *from <= *to && *to <= kMost) ||
      !(column >= 0 && column < static_cast<double>(index_.columns().size()))) {
    return text_answer(400,
                       "ask as /export.csv?from=TICK&to=TICK, of a comparison with &column=NUMBER");
  }
  index_.refresh();
  const auto first = std::max(static_cast<uint64_t>(*from), index_.first_tick());
  const auto last = std::min(static_cast<uint64_t>(*to), index_.last_tick());
  if (last >= first && last - first >= kMostRows) {
    return text_answer(413, "at most " + std::to_string(kMostRows) +
                                " ticks at a time; select fewer, or use `hapt export`");
  }
  const CsvRecords records = [&](const std::function<void(const std::byte*)>& use) {
    if (last < first) return;
    index_.for_each_frame(first, last, static_cast<size_t>(column), [&](const ServoFrame& frame) {
      use(reinterpret_cast<const std::byte*>(&frame));
    });
  };
  std::ostringstream text;
  export_csv(*find_topic(servo_topic(kFirstHand).name), records, text);
  return {200, "text/csv", shared_text(std::move(text).str())};
}

}  // namespace haptic
