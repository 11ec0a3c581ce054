// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "clients/desk/trial/trial_step.h"
#include "device-io/device.h"
#include "proto/os/realtime.h"

namespace haptic {

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
