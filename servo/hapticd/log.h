// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "proto/wire/wire.h"

namespace spdlog {
class logger;
}

namespace haptic {

enum class LogLevel { kInfo, kWarning, kError };

class PatientSink;

/// The one log of a session, on stderr: lines for people, or one JSON object a line. Real-time
/// processes never log; hapticd puts their events into words. Writing never waits for whoever
/// reads: what is not taken is kept for a while, then dropped and counted.
class HapticdLog {
 public:
  explicit HapticdLog(bool json);
  ~HapticdLog();
  HapticdLog(const HapticdLog&) = delete;

  /// `source` is who it is about: "hapticd", or the name of a segment.
  void write(LogLevel level, std::string_view source, const std::string& message);

  void write_event(std::string_view source, const Event& event);

  /// Writes what could not be written before; to be called now and then.
  void drain();

 private:
  std::shared_ptr<PatientSink> sink_;
  std::shared_ptr<spdlog::logger> logger_;
  bool json_;
};

/// An event in words, e.g. "started: pid 7, generation 2; real time: SCHED_FIFO memory locked".
std::string describe_event(const Event& event);

/// How loud it should be: a refused right, a fault and staleness are warnings.
LogLevel level_of(const Event& event);

}  // namespace haptic
