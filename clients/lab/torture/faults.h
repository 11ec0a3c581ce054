// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/lab/torture/fault_kinds.h"
#include "clients/lab/torture/session.h"

namespace haptic {

/// Result of one fault.
struct FaultOutcome {
  FaultKind kind{};
  std::vector<std::string> violations;   // one line each: what, when, how much
  std::vector<std::string> before;       // since the previous fault; caused by neither
  std::optional<int64_t> zero_after_ns;  // from the fault to the first zero; nothing: never zero
  std::optional<int64_t> recovery_ns;    // from restart (or end of the cause) to full force
  int64_t begin_ns = 0;
  size_t excused = 0;    // commands not checked, because the machine had stalled
  std::string left_out;  // why it was not injected; empty if it was
};

/// Injects faults into a session, waits each time for recovery and checks the forces that the
/// emulated device received. The seed determines the durations of stops.
class FaultInjector {
 public:
  FaultInjector(TortureSession& session, uint64_t seed)
      : session_(session), torturer_{session, std::mt19937_64(seed)} {}

  FaultOutcome inject(FaultKind kind);

  /// Earliest time for the next fault of a kind: hapticd delays the restart of a process that lived
  /// less than ten seconds, so the documented 200 ms do not apply to a second death before that.
  int64_t ready_ns(FaultKind kind) const;

 private:
  void change_hands(FaultOutcome& outcome);
  bool is_empty() const;
  void take_again(FaultOutcome& outcome);
  std::vector<std::string> judge_calm(int64_t until_ns) const;
  void judge(const FaultInfo& info, const Inflicted& done, FaultOutcome& outcome);

  TortureSession& session_;
  Torturer torturer_;
  int64_t judged_ns_ = 0;  // so far
  int n_faults_ = 0;
};

}  // namespace haptic
