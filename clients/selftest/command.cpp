// SPDX-License-Identifier: GPL-3.0-or-later
// hapt selftest: checks on this machine that the servo loop makes no blocking call.
#include <iostream>
#include <memory>
#include <optional>

#include "clients/hapt/commands.h"
#include "clients/hapt/find_config.h"
#include "clients/hapt/lab_commands.h"
#include "clients/report/print_rows.h"
#include "clients/report/report.h"
#include "clients/selftest/guarded_loop.h"
#include "contact/bake/session.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

struct SelftestOptions {
  std::string config = "plane.toml";
  std::optional<uint64_t> ticks;
  bool json = false;
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

Rows make_rows(const SessionConfig& config, const GuardedLoopResult& result) {
  Rows rows{std::string(view(config.name))};
  rows.note("machine", machine_line());
  rows.note("rights", result.rights.explain());
  rows.add("ticks under guard", result.ticks);
  const bool is_simulated = !has_node(config.device);
  // without contact a simulated hand tests little; a real hand is up to its user
  rows.at_least("of them in contact", result.contact_ticks, "", goal_if(is_simulated, 1));
  // a loop whose device did not answer has not been tested
  rows.none("of them without the device", result.lost_ticks);
  for (size_t kind = 0; kind < kViolations; ++kind) {
    const uint64_t count = result.report.caught[kind].count;
    rows.none(std::string("violations: ") + name_of(static_cast<Violation>(kind)), count);
  }
  // caused by other programs on this core
  rows.add("involuntary switches", result.report.involuntary_switches);
  // one sleep per timed tick and no other wait; on a node the kernel may wait for its own lock
  rows.add("voluntary switches", result.report.voluntary_switches, "",
           goal_if(is_simulated, static_cast<double>(result.timed_ticks)),
           result.stray_sleeps() == 0);
  return rows;
}

void run_selftest(const SelftestOptions& options) {
  const SessionConfig config = load_config(find_config(options.config));
  const BakedSession baked = bake_session(config);
  const GuardedLoopResult result =
      run_guarded_loop(config, baked.shapes(), loop_options(config, options.ticks));
  const Rows rows = make_rows(config, result);
  std::cerr << result.report.explain();
  print_judged(rows.rows(), options.json);
}

}  // namespace

void add_selftest_command(Command& app) {
  const auto options = std::make_shared<SelftestOptions>();
  Command command = app.subcommand(kSelftestCommand.name, kSelftestCommand.help);
  command.option("--config", options->config, "session file").show_default();
  command
      .option("--ticks", options->ticks,
              "how many, as fast as they go [1000000]; with a real device on the clock [10000]")
      .range(uint64_t{1}, uint64_t{1'000'000'000});
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { run_selftest(*options); });
}

}  // namespace haptic
