// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace haptic {

class Command;

/// The session that a command acts on, as typed.
struct SessionChoice {
  std::string name;  // empty: the only one that runs
  double wait = 0;   // how long it may take to come up [s]
};

/// The options --session and --wait.
void add_session(Command& command, SessionChoice& session);

/// Name of the session as typed, once it answers, or when the wait is over or ended by a signal:
/// whoever then connects says what is wrong. Returns at once where there is nothing to wait for.
const std::string& once_up(const SessionChoice& session);

}  // namespace haptic
