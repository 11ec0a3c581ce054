// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "servo/hapticd/session_run.h"

namespace haptic {

/// Knows until when somebody leads a simulated hand, if anybody does. The servo keeps that time by
/// itself (servo/lead.h); this keeps the desired state true for those who watch.
class Leads {
 public:
  explicit Leads(SessionRun& session) : session_(session) {}

  /// Publishes a desired state that `line`, a command to lead or to release, has changed.
  void take(std::string_view line);
  /// Releases a hand that nobody has led for kLeadNs. To be called regularly.
  void look(int64_t t_ns);

 private:
  SessionRun& session_;
  std::optional<int64_t> until_ns_;  // none: nobody leads
};

}  // namespace haptic
