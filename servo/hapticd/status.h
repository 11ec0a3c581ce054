// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <ctime>
#include <string>
#include <vector>

#include "proto/config/out_of_reach.h"
#include "proto/wire/wire.h"
#include "servo/hapticd/giving/giver_report.h"

namespace haptic {

/// The answer of `hapt status` about a session.
struct SessionStatus {
  struct Process {
    std::string name;
    pid_t pid = -1;
    uint64_t generation = 0;
    bool runs = false;
  };
  struct Spare {
    pid_t pid = -1;
    uint64_t generation = 0;
    bool is_ready = false;
  };
  struct Hand {
    std::string name, device;
    bool runs = false;  // its servo
    ControlFrame wanted{};
    ServoFrame servo{};  // the newest; tick 0 before the first
  };
  std::string session;
  std::time_t since = 0, now = 0;
  std::vector<Hand> hands;  // one at least
  std::vector<Process> processes;
  Spare spare;
  size_t clients = 0;
  OutOfReach gone;
  std::vector<GiverReport> givers;
};

/// Lines for people.
std::string status_text(const SessionStatus& status);

/// One line of JSON (docs/architecture.md).
std::string status_json(const SessionStatus& status);

}  // namespace haptic
