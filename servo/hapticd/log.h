// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "proto/wire/wire.h"

namespace spdlog {
class logger;
}

namespace haptic {

enum class LogLevel { kInfo, kWarning, kError };

class PatientSink;

/// The log of a session, on stderr: text lines, or one JSON object per line. Real-time processes
/// never log; hapticd writes their events. Writing never waits for the reader: lines are kept for a
/// while, then dropped and counted.
class HapticdLog {
 public:
  explicit HapticdLog(bool json);
  ~HapticdLog();
  HapticdLog(const HapticdLog&) = delete;

  /// `source` is the subject: "hapticd", or the name of a segment.
  void write(LogLevel level, std::string_view source, const std::string& message);

  void write_event(std::string_view source, const Event& event);

  /// Writes kept lines; to be called regularly.
  void drain();

 private:
  std::shared_ptr<PatientSink> sink_;
  std::shared_ptr<spdlog::logger> logger_;
  bool json_;
};

/// Text of an event, e.g. "started: pid 7, generation 2; real time: SCHED_FIFO memory locked".
std::string describe_event(const Event& event);

/// Level and text of a line that a child has written (kWarningLine, kErrorLine).
std::pair<LogLevel, std::string_view> level_of_line(std::string_view line);

/// Warning for refused rights, faults and stale contacts; else info.
LogLevel level_of(const Event& event);

}  // namespace haptic
