// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "clients/log/log_survey.h"
#include "proto/math/pose.h"

/// The text messages of a page (docs/view-protocol.md).
namespace haptic {

struct TokenMessage {
  std::string token;
};
struct ShownMessage {
  uint64_t sequence = 0;
};
struct RateMessage {
  double hz = 60;  // 1 to 120
};
struct CommandMessage {
  std::string id;  // as JSON, to be sent back
  std::string line;
};
struct LeadMessage {
  Vec3 position_W;
  std::optional<Quat> orientation;
};
struct ReleaseMessage {};
// the messages that move in a log; a session has none
struct SeekMessage {
  uint64_t tick = 0;
};
struct PlayMessage {
  double speed = 1;  // 0.1 to 4
};
struct StopMessage {};
struct StepMessage {
  int64_t ticks = 0;
};
struct NextMessage {
  MarkKind kind{};
  bool forward = true;
};
struct LoopMessage {
  std::optional<std::pair<uint64_t, uint64_t>> ticks;  // none: no loop any more
};
using LogMessage =
    std::variant<SeekMessage, PlayMessage, StopMessage, StepMessage, NextMessage, LoopMessage>;
/// A text that is no message, and why, in words for a close frame.
struct BadMessage {
  std::string problem;
};
using PageMessage = std::variant<BadMessage, TokenMessage, ShownMessage, RateMessage,
                                 CommandMessage, LeadMessage, ReleaseMessage, LogMessage>;

/// Never throws: any bytes give a message or a BadMessage.
PageMessage parse_page_message(std::string_view text);

/// The line for the control socket that lets the simulated hand mean to go there, and the one that
/// ends it.
std::string lead_line(const LeadMessage& lead);
std::string release_line();

}  // namespace haptic
