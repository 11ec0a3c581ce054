// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/config/config.h"
#include "proto/wire/wire.h"
#include "servo/hapticd/status.h"

namespace haptic {

/// Request of a line from the control socket.
enum class CommandKind { kQuestion, kStop, kChange, kLead, kRefused };

/// Answers a question, given the status and the text of the session file.
using AnswerText = std::string(const SessionStatus& status, const std::string& config_text);

struct ControlCommand {
  CommandKind kind = CommandKind::kRefused;
  AnswerText* answer = nullptr;  // of a question
  bool clears_fault = false;
  std::string problem = {};  // one line: why it is refused
  std::string warning = {};  // one line: what to know of a change; empty: nothing
};

/// A line without the hand that it names, and the hands that it is for: the one of "hand NAME …",
/// else all.
struct AddressedLine {
  std::string_view line;
  std::vector<uint32_t> hands;
  std::string problem = {};  // one line: the session has no such hand; empty: it has
};
AddressedLine read_address(std::string_view line, const SessionConfig& config);

/// Parses one line and applies it to the desired state of a hand, wholly or not at all:
///   status (one line of JSON) | status text | config | stop
///   clear-fault | arm | disarm | pause | resume
///   set stiffness "500 N/m" | set damping "2 N·s/m" | set time-scale 0.5
///   set rotational-stiffness "2 N·m/rad" | set rotational-damping "1e-3 N·m·s/rad"
///   set renderer NAME, if the session has the tool and the maps it needs
///   set solver NAME, of a renderer of a soft body
///   lead X Y Z [QW QX QY QZ], where a simulated hand is led to: the tool's pose in W [m] | release
/// A `set` with which the hand would feel far more than the device holds (too_stiff) is refused,
/// unless the line ends in --force.
/// A change gives `wanted` a new revision. To lead (kLead) is one that is answered at once; its
/// instant, intent_t_ns, is the caller's to set.
ControlCommand apply_command(std::string_view line, const SessionConfig& config,
                             ControlFrame& wanted);

}  // namespace haptic
