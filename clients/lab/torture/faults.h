// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "clients/lab/torture/fault_kinds.h"
#include "clients/lab/torture/session.h"
#include "device-io/emulator/fault_order.h"

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
  FaultInjector(TortureSession& session, uint64_t seed) : session_(session), random_(seed) {}

  FaultOutcome inject(FaultKind kind);

  /// Earliest time for the next fault of a kind: hapticd delays the restart of a process that lived
  /// less than ten seconds, so the documented 200 ms do not apply to a second death before that.
  int64_t ready_ns(FaultKind kind) const;

 private:
  /// Times of an injected fault, for the check. It begins when it is known to have happened,
  /// because this program may be stalled before that.
  struct Done {
    int64_t begin_ns = 0;
    int64_t from_ns = 0;  // before it was injected
    int64_t over_ns = 0;
    int64_t soft_ns = 0;           // first tick of a new servo
    int64_t whole_from_ns = 0;     // commands from here on count for recovery
    int64_t recovery_from_ns = 0;  // start of the recovery time
    bool recovers = true;          // false: the force never left, no recovery time
    int64_t recovered_ns = 0;      // end of recovery if not given by the force; 0: it is
    int64_t waited_ns = 0;         // for a processor, by the restarted process
    std::vector<std::string> problems = {};
    std::string left_out = {};
  };

  void change_hands(FaultOutcome& outcome);
  void take_again(FaultOutcome& outcome);
  Done inflict(FaultKind kind);
  Done kill_contact(bool hang);
  Done stop_contact();
  Done close_by(const std::function<void()>& cause, const std::function<void()>& cure = {});
  Done lie(EmulatorFault how);
  Done slow_contact(FaultKind kind);
  Done lie_in_contact();
  Done kill_sim();
  Done stop_sim();
  Done fell_servo(int signal);
  Done pause_servo();
  Done kill_hapticd(bool servo_too);
  /// Whether the firmware's watchdog has switched the motors off since then.
  bool has_let_go(int64_t since_ns) const;
  Done stop_hapticd();
  Done kill_recorder();
  Done stop_recorder();
  Done fell_client(int signal);
  Done fell_many_clients();
  Done silence_device();
  Done stress(const std::vector<std::string>& words);
  Done stop_for(const std::function<void(int)>& send, int64_t least_ns, int64_t most_ns);
  void clear_fault(Done& done);
  void wait_for_spare(Done& done);
  int64_t between(int64_t least_ns, int64_t most_ns);
  std::vector<std::string> judge_calm(int64_t until_ns) const;
  void judge(const FaultInfo& info, const Done& done, FaultOutcome& outcome);

  TortureSession& session_;
  std::mt19937_64 random_;
  int64_t judged_ns_ = 0;                                    // so far
  int n_faults_ = 0;
};

}  // namespace haptic
