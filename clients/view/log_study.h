// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/log/log_survey.h"
#include "clients/view/web/web.h"

namespace haptic {

/// The jobs that read long parts of a log: its marks, overviews and selections. It has a reader of
/// its own, for a thread of its own.
class LogStudy {
 public:
  /// `q_WB`: the base of the device in W. Throws McapError.
  LogStudy(const std::string& path, const Quat& q_WB);

  struct Piece {
    std::vector<LogMark> marks;  // that were found
    bool has_more = false;       // there is more to be read
    bool is_news = false;        // anything has been read
    std::string problem;         // why no more can be read; empty: none
  };
  /// Reads on for about kPieceTime. Throws McapError.
  Piece advance();

  /// The answers to /overview.json and /export.csv; wrong questions are answered by why.
  WebAnswer overview(std::string_view query);
  WebAnswer table(std::string_view query);

 private:
  std::vector<LogStep> steps_of(double from, double to, size_t n, size_t column);
  std::vector<LogStep> exact_steps(double from, double to, size_t n, size_t column);

  LogIndex index_;
  LogSurvey survey_;
  Quat q_WB_;
  size_t n_told_ = 0;  // marks
};

}  // namespace haptic
