// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "clients/desk/trial/trial_step.h"
#include "clients/desk/trial/weighing.h"
#include "device-io/device.h"
#include "proto/os/realtime.h"

namespace haptic {

/// The limits of a force that leads a bare arm: 30 %, and none that is for a hand.
SafetyLimits weighing_limits(SafetyLimits limits);

/// Runs the steps of a trial on an open device, a tick a period, and leaves it with zero force
/// whatever ends it. SIGINT, SIGTERM and SIGHUP end it (catch_stop_signals()): ExitCode 130.
class TrialRun {
 public:
  TrialRun(Device& device, const SafetyLimits& limits, double rate);
  ~TrialRun() { device_.stop(); }
  TrialRun(const TrialRun&) = delete;

  std::vector<TrialRow> look(const std::function<void(const DeviceState&)>& show);
  std::vector<TrialRow> push();
  std::vector<TrialRow> full();
  /// Leads the arm, which nobody holds, until it is weighed; a line where it ended before.
  std::string weigh(Weighing& weighing, const std::function<void()>& show);

  /// Without force, until `done`.
  void wait_for(const std::function<bool()>& done);

 private:
  using Wanted = std::function<Wrench(const DeviceState&, double t)>;
  using Note = std::function<void(const DeviceState&, const Wrench& F_B, double t)>;

  /// Ticks for `time` seconds, or until the guard ends it.
  void run(GuardedHand& guard, double time, const Wanted& wanted, const Note& note);
  void tick(GuardedHand& guard, double t, const Wanted& wanted, const Note& note);

  Device& device_;
  SafetyLimits limits_;
  double dt_;
  DeadlineClock clock_;
  DeviceState state_{};
};

}  // namespace haptic
