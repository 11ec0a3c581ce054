// SPDX-License-Identifier: GPL-3.0-or-later
// hapt selftest: on this machine, the loop does nothing that may block.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "clients/find_config.h"
#include "clients/guarded_loop.h"
#include "clients/hapt_commands.h"
#include "clients/report.h"
#include "contact/bake.h"

namespace haptic {
namespace {

struct SelftestOptions {
  std::string config = "plane.toml";
  GuardedLoopOptions loop;
  bool json = false;
};

Rows make_rows(const std::string& name, const GuardedLoopResult& result) {
  Rows rows(name);
  rows.note("machine", machine_line());
  rows.note("rights", result.rights.explain());
  rows.add("ticks under guard", static_cast<double>(result.ticks), "");
  // a hand that never touched would show little
  rows.add("of them in contact", static_cast<double>(result.contact_ticks), "", 1,
           result.contact_ticks > 0);
  for (size_t kind = 0; kind < kViolations; ++kind) {
    const uint64_t count = result.report.caught[kind].count;
    rows.add(std::string("violations: ") + name_of(static_cast<Violation>(kind)),
             static_cast<double>(count), "", 0, count == 0);
  }
  // the machine's doing: whoever else runs on this core
  rows.add("involuntary switches", static_cast<double>(result.report.involuntary_switches), "");
  rows.add("voluntary switches", static_cast<double>(result.report.voluntary_switches), "");
  return rows;
}

void run_selftest(const SelftestOptions& options) {
  const SessionConfig config = load_config(find_config(options.config));
  std::vector<BakedShape> baked;
  std::vector<MeshShape> shapes;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    baked.push_back(bake_object(config.objects[i], config.mesh_memory_limit));
    shapes.push_back(baked.back().shape);
  }
  const GuardedLoopResult result = run_guarded_loop(config, shapes, options.loop);
  const Rows rows = make_rows(std::string(view(config.name)), result);
  if (options.json) {
    print_json(std::cout, rows.rows());
  } else {
    print_table(std::cout, rows.rows());
  }
  std::cout.flush();
  std::cerr << result.report.explain();
  if (!all_hold(rows.rows())) throw CLI::RuntimeError(1);
}

}  // namespace

void add_selftest_command(CLI::App& app) {
  const auto options = std::make_shared<SelftestOptions>();
  CLI::App* command = app.add_subcommand(
      "selftest", "Prove that the loop allocates, locks, faults and asks the kernel for nothing");
  command->add_option("--config", options->config, "session file")->capture_default_str();
  command->add_option("--ticks", options->loop.ticks, "how many, as fast as they go")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000'000}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { run_selftest(*options); });
}

}  // namespace haptic
