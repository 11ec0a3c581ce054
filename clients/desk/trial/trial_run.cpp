// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/trial_run.h"

#include <array>

#include "proto/config/command_line.h"
#include "proto/ipc/process.h"

namespace haptic {
namespace {

constexpr double kGentle = 0.05;       // share of the force that has not been felt before
constexpr double kWeighing = 0.3;      // share of the force that an arm is weighed with
constexpr double kAnyWay = 1;          // [m]; the arm is led, and no hand gives way
constexpr int kExitInterrupted = 130;  // 128 + SIGINT

constexpr std::array kEndWords{"", "the device stopped answering, or is no longer homed",
                               "a fault: the pose jumped, was noisy, old or no number",
                               "the handle went too fast; hold it",
                               "the handle went too far; hold it"};  // by TrialEnd

constexpr std::array kWeighEndWords{
    "", "somebody has touched it", "it moved 5 mm aside of where it was led",
    "it did not come along: it is heavier than 30 % of the force, or something is in its way"};

std::vector<TrialRow> with_end(std::vector<TrialRow> rows, TrialEnd end) {
  if (end != TrialEnd::kNone) {
    rows.push_back(
        {"ended before its time", kEndWords[static_cast<size_t>(end)], Verdict::kFailed});
  }
  return rows;
}

}  // namespace

TrialRun::TrialRun(Device& device, const SafetyLimits& limits, double rate)
    : device_(device), limits_(limits), dt_(1 / rate), clock_(period_ns(rate)) {}

void TrialRun::tick(GuardedHand& guard, double t, const Wanted& wanted, const Note& note) {
  if (stop_requested()) throw ExitCode{kExitInterrupted};
  const Tick tick = clock_.wait();
  const int64_t woke_ns = tick.deadline_ns + tick.late_ns;
  device_.read({tick.deadline_ns, woke_ns}, state_);
  const Wrench F_B = guard.tick(state_, woke_ns, wanted(state_, t), dt_);
  device_.write(F_B);
  note(state_, F_B, t);
}

void TrialRun::run(GuardedHand& guard, double time, const Wanted& wanted, const Note& note) {
  const int64_t begin_ns = now_ns();
  for (double t = 0; t < time && guard.end() == TrialEnd::kNone;
       t = 1e-9 * static_cast<double>(now_ns() - begin_ns)) {
    tick(guard, t, wanted, note);
  }
  device_.write({});
}

void TrialRun::wait_for(const std::function<bool()>& done) {
  GuardedHand guard(limits_, 0);
  while (!done()) {
    tick(
        guard, 0, [](const DeviceState&, double) { return Wrench{}; },
        [](const DeviceState&, const Wrench&, double) {});
  }
}

std::vector<TrialRow> TrialRun::look(const std::function<void(const DeviceState&)>& show) {
  GuardedHand guard(limits_, 0);
  LookStep step;
  run(
      guard, LookStep::kTime, [](const DeviceState&, double) { return Wrench{}; },
      [&](const DeviceState& device, const Wrench&, double t) {
        step.note(device, t);
        show(device);
      });
  return step.rows();
}

std::vector<TrialRow> TrialRun::push() {
  GuardedHand guard(limits_, kGentle);
  PushStep step(guard.limits());
  run(
      guard, step.time(), [&](const DeviceState&, double t) { return step.wanted(t); },
      [&](const DeviceState& device, const Wrench&, double t) { step.note(device, t); });
  return with_end(step.rows(), guard.end());
}

std::vector<TrialRow> TrialRun::full() {
  GuardedHand guard(limits_, 1);
  FullStep step(guard.limits());
  run(
      guard, FullStep::kTime,
      [&](const DeviceState& device, double t) { return step.wanted(device, t); },
      [&](const DeviceState& device, const Wrench& F_B, double t) { step.note(device, F_B, t); });
  return with_end(step.rows(), guard.end());
}

SafetyLimits weighing_limits(SafetyLimits limits) {
  limits.max_force *= kWeighing;
  limits.max_torque *= kWeighing;
  // what lifts an arm gives it energy, and it may rest beyond the edge
  limits.max_damping = limits.max_rotational_damping = 0;
  limits.workspace_radius = limits.workspace_turn = 0;
  return limits;
}

std::string TrialRun::weigh(Weighing& weighing, const std::function<void()>& show) {
  GuardedHand guard(weighing_limits(limits_), 1, kAnyWay);
  const int64_t begin_ns = now_ns();
  while (!weighing.is_over() && guard.end() == TrialEnd::kNone) {
    tick(
        guard, 1e-9 * static_cast<double>(now_ns() - begin_ns),
        [&](const DeviceState& device, double t) { return weighing.wanted(device, t); },
        [&](const DeviceState& device, const Wrench& F_B, double) { weighing.note(device, F_B); });
    show();
  }
  device_.write({});
  if (guard.end() != TrialEnd::kNone) return kEndWords[static_cast<size_t>(guard.end())];
  return kWeighEndWords[static_cast<size_t>(weighing.end())];
}

}  // namespace haptic
