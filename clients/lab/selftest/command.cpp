// SPDX-License-Identifier: GPL-3.0-or-later
// hapt selftest: checks on this machine that the servo loop makes no blocking call.
#include <atomic>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/lab/selftest/guarded_loop.h"
#include "clients/lab/support/measurement.h"
#include "clients/report/report.h"
#include "contact/bake/session.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

struct SelftestOptions {
  std::string config = "plane.toml";
  std::optional<uint64_t> ticks;
};

GuardedLoopOptions loop_options(const SessionConfig& config, std::optional<uint64_t> ticks) {
  constexpr uint64_t kTimed = 10'000;  // a real device runs on the wall clock
  GuardedLoopOptions loop;
  if (has_node(config.device)) {
    loop.warm_up = loop.timed_ticks;
    loop.ticks = kTimed;
  }
  if (ticks) loop.ticks = *ticks;
  return loop;
}

void add_rows(const SessionConfig& config, const GuardedLoopResult& result, const Rows& all) {
  Rows rows = all.machine(std::string(view(config.name)));
  const bool is_simulated = !has_node(config.device);
  rows.add({{"rights", result.rights.explain()},
            {"ticks under guard", result.ticks},
            // without contact a simulated hand tests little; a real hand is up to its user
            {"of them in contact", result.contact_ticks, "", at_least(goal_if(is_simulated, 1))},
            // a loop whose device did not answer has not been tested
            {"of them without the device", result.lost_ticks, "", kMustBeZero}});
  for (size_t kind = 0; kind < kViolations; ++kind) {
    const uint64_t count = result.report.caught[kind].count;
    rows.add(std::string("violations: ") + name_of(static_cast<Violation>(kind)), count, "",
             kMustBeZero);
  }
  // caused by other programs on this core
  rows.add(
      {{"involuntary switches", result.report.involuntary_switches},
       // one sleep per timed tick and no other wait; on a node the kernel may wait for its own lock
       {"voluntary switches", result.report.voluntary_switches, "",
        given(goal_if(is_simulated, static_cast<double>(result.timed_ticks)),
              result.stray_sleeps() == 0)}});
}

/// Another thread shows the progress: the guarded one may not write.
GuardedLoopResult run_shown(const SessionConfig& config, const ContactShapes& shapes,
                            GuardedLoopOptions loop) {
  constexpr int64_t kLookNs = kNsPerSecond / 10;
  std::atomic<uint64_t> done{0};
  loop.also_do = [&](uint64_t k) { done.store(k, std::memory_order_relaxed); };
  const std::jthread shows([&](const std::stop_token& stop) {
    Progress progress("checking ticks", static_cast<double>(loop.ticks + loop.timed_ticks));
    while (!stop.stop_requested()) {
      progress.at(static_cast<double>(done.load(std::memory_order_relaxed)));
      sleep_until(now_ns() + kLookNs);
    }
  });
  return run_guarded_loop(config, shapes, loop);
}

void eval_selftest(const SelftestOptions& options, const Rows& all) {
  const SessionConfig config = load_config(find_session_file(options.config));
  const BakedSession baked = bake_session(config);
  const GuardedLoopResult result =
      run_shown(config, baked.shapes(), loop_options(config, options.ticks));
  add_rows(config, result, all);
  std::cerr << result.report.explain();
}

Measured prepare_selftest(Command& command) {
  const auto options = std::make_shared<SelftestOptions>();
  add_config(command, options->config).show_default();
  command.option("--ticks", options->ticks, "how many, one after the other without waiting")
      .range(1, 1'000'000'000)
      .show_default("1000000; with a real device 10000, at its rate");
  return measured(eval_selftest, options);
}

}  // namespace

void add_selftest_command(Command& app) {
  measure_by(add_elsewhere(app, "selftest"), prepare_selftest, "hapt selftest --config plane.toml");
}

}  // namespace haptic
