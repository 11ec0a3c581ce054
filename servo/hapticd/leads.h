// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "servo/hapticd/session_run.h"

namespace haptic {

/// Knows until when somebody leads each simulated hand, if anybody does. The servo keeps that time
/// by itself (servo/lead.h); this keeps the desired state true for those who watch.
class Leads {
 public:
  explicit Leads(SessionRun& session) : session_(session) {}

  /// Publishes a hand's desired state, which `line`, a command to lead or to release, has changed.
  void take(uint32_t hand, std::string_view line);
  /// Releases hands that nobody has led for kLeadNs. To be called regularly.
  void look(int64_t t_ns);

 private:
  SessionRun& session_;
  std::array<std::optional<int64_t>, kMostHands> until_ns_;  // by hand; none: nobody leads
};

}  // namespace haptic
