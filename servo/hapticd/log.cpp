// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/log.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/patient_sink.h"
#include "servo/hapticd/state_words.h"

namespace haptic {
namespace {

constexpr int64_t kLastWordsNs = kNsPerSecond / 5;  // wait for a slow reader at the end [ns]

uint64_t whole(double number) {
  return static_cast<uint64_t>(number);
}

std::string rights(const std::array<double, 5>& n) {
  RealtimeReport report;
  report.bits = static_cast<uint32_t>(n[2]);
  report.fifo_errno = static_cast<int>(n[3]);
  report.memory_errno = static_cast<int>(n[4]);
  return report.explain();
}

/// By the numbers of LogLevel.
constexpr std::array kLevels{spdlog::level::info, spdlog::level::warn, spdlog::level::err};

}  // namespace

std::string describe_event(const Event& event) {
  const std::array<double, 5>& n = event.numbers;
  switch (static_cast<EventCode>(event.code)) {
    case EventCode::kStarted:
      return fmt::format("started: pid {}, generation {}; {}", whole(n[0]), whole(n[1]), rights(n));
    case EventCode::kFlagsChanged:
      return fmt::format("state: {} -> {} (tick {})", state_text(static_cast<uint32_t>(n[0])),
                         state_text(static_cast<uint32_t>(n[1])), whole(n[2]));
    case EventCode::kStopped:
      return fmt::format("stopped after {} cycles, {} skipped", whole(n[0]), whole(n[1]));
    case EventCode::kFault:
      return fmt::format(
          "FAULT at tick {}: {} (handle at {:.3g} m/s, {:.3g} N asked for); the force is off until "
          "'hapt clear-fault'",
          whole(n[1]), reason_of(static_cast<Fault>(n[0])), n[2], n[3]);
    case EventCode::kRecordsLost:
      return fmt::format("{} {} of generation {} not recorded, {} in all", whole(n[0]),
                         n[3] != 0 ? "events" : "frames", whole(n[2]), whole(n[1]));
    case EventCode::kSessionBack:
      return fmt::format("hapticd is back after {:.2f} s; the last tick before was {}", n[0],
                         whole(n[1]));
  }
  return fmt::format("event {}: {} {} {} {} {}", event.code, n[0], n[1], n[2], n[3], n[4]);
}

std::pair<LogLevel, std::string_view> level_of_line(std::string_view line) {
  if (line.starts_with(kErrorLine)) return {LogLevel::kError, line.substr(kErrorLine.size())};
  if (line.starts_with(kWarningLine)) return {LogLevel::kWarning, line.substr(kWarningLine.size())};
  return {LogLevel::kInfo, line};
}

LogLevel level_of(const Event& event) {
  constexpr uint32_t kLoud = kServoFault | kServoStale;
  const EventCode code = static_cast<EventCode>(event.code);
  const bool refused =
      code == EventCode::kStarted && (event.numbers[3] > 0 || event.numbers[4] > 0);
  const bool loud =
      code == EventCode::kFlagsChanged && (static_cast<uint32_t>(event.numbers[1]) & kLoud) != 0;
  return refused || loud || code == EventCode::kFault ? LogLevel::kWarning : LogLevel::kInfo;
}

HapticdLog::HapticdLog(bool json)
    : sink_(std::make_shared<PatientSink>(STDERR_FILENO)),
      logger_(std::make_shared<spdlog::logger>("hapticd", sink_)),
      json_(json) {
  logger_->set_pattern(json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v})"
                            : "%H:%M:%S.%e %^%l%$ %v");
  logger_->flush_on(spdlog::level::info);
}

HapticdLog::~HapticdLog() {
  sink_->drain_for(kLastWordsNs);
}

void HapticdLog::drain() {
  sink_->drain();
}

void HapticdLog::write(LogLevel level, std::string_view source, const std::string& message) {
  const std::string line = one_line(message);
  const std::string text =
      json_ ? fmt::format(R"("source":{},"message":{})", json_line(source), json_line(line))
            : fmt::format("{}: {}", source, line);
  logger_->log(kLevels[static_cast<size_t>(level)], text);
}

void HapticdLog::write_event(std::string_view source, const Event& event) {
  write(level_of(event), source, describe_event(event));
}

}  // namespace haptic
