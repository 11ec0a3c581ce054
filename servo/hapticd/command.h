// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// What a line that came over the control socket asks for.
enum class CommandKind { kStatus, kConfig, kStop, kChange, kRefused };

struct Command {
  CommandKind kind = CommandKind::kRefused;
  bool clears_fault = false;
  std::string problem;  // why it is refused, in one line
};

/// Understands one line and applies it to the desired state (never partly):
///   status | config | stop | clear-fault | arm | disarm | pause | resume
///   set stiffness "500 N/m" | set damping "2 N·s/m" | set time-scale 0.5
///   set rotational-stiffness "2 N·m/rad" | set rotational-damping "1e-3 N·m·s/rad"
///   set renderer NAME, one that the session has a tool and maps for
/// `wanted` gets a new revision when it changes.
Command apply_command(std::string_view line, const SessionConfig& config, ControlFrame& wanted);

}  // namespace haptic
