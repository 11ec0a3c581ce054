// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/log.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/patient_sink.h"

namespace haptic {
namespace {

constexpr std::array kServoFlagNames{std::pair{kServoContact, "contact"},
                                     std::pair{kServoNoContactSet, "no contacts yet"},
                                     std::pair{kServoHolding, "holding"},
                                     std::pair{kServoFading, "fading"},
                                     std::pair{kServoStale, "contacts stale"},
                                     std::pair{kServoReopening, "reopening"},
                                     std::pair{kServoSaturated, "saturated"},
                                     std::pair{kServoSoftStart, "soft start"},
                                     std::pair{kServoFault, "FAULT"},
                                     std::pair{kServoClutched, "clutched"},
                                     std::pair{kServoPaused, "paused"},
                                     std::pair{kServoSolverLimit, "solver limit"},
                                     std::pair{kServoTorqueDropped, "no torque actuators"},
                                     std::pair{kServoDisarmed, "not armed: hapt arm"},
                                     std::pair{kServoTooFast, "too fast"},
                                     std::pair{kServoSlewing, "slewing"},
                                     std::pair{kServoThermal, "motors warm"},
                                     std::pair{kServoPassivity, "damped to stay passive"},
                                     std::pair{kServoWorkspaceEdge, "edge of the workspace"},
                                     std::pair{kServoNoDevice, "device lost or not homed"}};

constexpr int64_t kLastWordsNs = kNsPerSecond / 5;  // wait for a slow reader at the end [ns]

const char* reason(Fault fault) {
  constexpr std::array kReasons{
      "unknown",
      "the device's sample was not finite",
      "the contacts or the poses of objects were not finite",
      "the force was not finite",
      "the force was beyond all reason",
      "the pose of the device jumped",
      "the device does not answer what it is asked (frozen, or old answers): plug it out and in "
      "again",
      "an encoder of the device is noisy: check its cable and plug"};
  const auto i = static_cast<size_t>(fault);
  return kReasons[i < kReasons.size() ? i : 0];
}

uint64_t whole(double number) {
  return static_cast<uint64_t>(number);
}

std::string flag_names(uint32_t flags) {
  std::string text;
  for (const auto& [flag, name] : kServoFlagNames) {
    if ((flags & flag) != 0) text += (text.empty() ? "" : ", ") + std::string(name);
  }
  return text.empty() ? "all well" : text;
}

std::string rights(const std::array<double, 5>& n) {
  RealtimeReport report;
  report.bits = static_cast<uint32_t>(n[2]);
  report.fifo_errno = static_cast<int>(n[3]);
  report.memory_errno = static_cast<int>(n[4]);
  return report.explain();
}

std::string json_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out;
}

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      break;
  }
  return spdlog::level::err;
}

}  // namespace

std::string describe_event(const Event& event) {
  const std::array<double, 5>& n = event.numbers;
  switch (static_cast<EventCode>(event.code)) {
    case EventCode::kStarted:
      return fmt::format("started: pid {}, generation {}; {}", whole(n[0]), whole(n[1]), rights(n));
    case EventCode::kFlagsChanged:
      return fmt::format("{} (was: {}) at tick {}", flag_names(static_cast<uint32_t>(n[1])),
                         flag_names(static_cast<uint32_t>(n[0])), whole(n[2]));
    case EventCode::kStopped:
      return fmt::format("stopped after {} cycles, {} skipped", whole(n[0]), whole(n[1]));
    case EventCode::kFault:
      return fmt::format(
          "FAULT at tick {}: {} (handle at {:.3g} m/s, {:.3g} N asked for); the force is off until "
          "'hapt clear-fault'",
          whole(n[1]), reason(static_cast<Fault>(n[0])), n[2], n[3]);
    case EventCode::kRecordsLost:
      return fmt::format("{} {} of generation {} not recorded, {} in all", whole(n[0]),
                         n[3] != 0 ? "events" : "frames", whole(n[2]), whole(n[1]));
  }
  return fmt::format("event {}: {} {} {} {} {}", event.code, n[0], n[1], n[2], n[3], n[4]);
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
      json_ ? fmt::format(R"("source":"{}","message":"{}")", json_text(source), json_text(line))
            : fmt::format("{}: {}", source, line);
  logger_->log(spdlog_level(level), text);
}

void HapticdLog::write_event(std::string_view source, const Event& event) {
  write(level_of(event), source, describe_event(event));
}

}  // namespace haptic
