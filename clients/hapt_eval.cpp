// SPDX-License-Identifier: GPL-3.0-or-later
// hapt eval: the whole chain in lockstep on virtual time, judged and repeated bit for bit.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>

#include "clients/find_config.h"
#include "clients/hapt_commands.h"
#include "clients/lockstep.h"
#include "clients/session_plot.h"
#include "clients/summary.h"

namespace haptic {
namespace {

struct EvalOptions {
  std::string config = "bunny.toml", trace, plot;
  double duration = 20;
  LockstepOptions lockstep;
  bool json = false;
};

struct EvalRun {
  SessionData data;
  std::vector<double> step_seconds;  // servo + contact + sim, one tick
  uint64_t hash = 0;
};

EvalRun run_lockstep(const SessionConfig& config, const std::vector<MeshShape>& shapes,
                     const EvalOptions& options) {
  using Clock = std::chrono::steady_clock;
  EvalRun run;
  const std::unique_ptr<Device> device = open_device(config.device);
  Lockstep lockstep(config, shapes, *device, options.lockstep);
  const bool replay = config.device.kind == DeviceKind::kReplay;
  const auto ticks = static_cast<uint64_t>(options.duration * config.servo_rate);
  // a recording is played to its end, a simulated hand for the time asked
  for (uint64_t k = 0; replay || k < ticks; ++k) {
    const auto start = Clock::now();
    if (!lockstep.step()) break;
    run.step_seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    run.data.frames.push_back(lockstep.frame());
    if (run.data.scenes.empty() || run.data.scenes.back().seq != lockstep.scene().seq) {
      run.data.scenes.push_back(lockstep.scene());
    }
    const ContactSet* set = lockstep.contacts();
    if (set != nullptr &&
        (run.data.proxies.empty() || run.data.proxies.back().answers_t_ns != set->answers_t_ns)) {
      run.data.proxies.push_back(verified_proxy(*set));
    }
  }
  run.hash = lockstep.hash();
  return run;
}

void add_lab_rows(const std::string& name, EvalRun first, const EvalRun& second,
                  std::vector<Row>& rows) {
  std::sort(first.step_seconds.begin(), first.step_seconds.end());
  const size_t n = first.step_seconds.size();
  const auto add = [&](const std::string& metric, double value, const std::string& unit) {
    rows.push_back({name, metric, value, unit, "", {}, {}, {}});
  };
  if (n > 0) {
    add("one tick, all three steps p50", first.step_seconds[n / 2], "s");
    add("one tick, all three steps p99", first.step_seconds[n * 99 / 100], "s");
    add("one tick, all three steps max", first.step_seconds.back(), "s");
  }
  const bool same = first.hash == second.hash && n == second.step_seconds.size();
  rows.push_back({name,
                  "runs that differ from the first, of 1 repeated",
                  same ? 0.0 : 1.0,
                  "",
                  "",
                  {},
                  0.0,
                  same});
}

void run_eval(const EvalOptions& options) {
  SessionConfig config = load_config(find_config(options.config));
  if (!options.trace.empty()) use_trace(config, options.trace);
  std::vector<BakedShape> baked;
  std::vector<MeshShape> shapes;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    baked.push_back(bake_object(config.objects[i], config.mesh_memory_limit));
    for (const std::string& line : baked.back().report.lines) std::cerr << line << '\n';
    shapes.push_back(baked.back().shape);
  }
  const EvalRun first = run_lockstep(config, shapes, options);
  const EvalRun second = run_lockstep(config, shapes, options);
  const std::string name(view(config.name));
  std::vector<Row> rows =
      summarize(name, first.data, config, measure_penetration(first.data, config, baked));
  // on virtual time nothing is late or busy
  std::erase_if(rows, [](const Row& row) { return row.unit == "s"; });
  add_lab_rows(name, first, second, rows);

  if (options.json) {
    print_json(std::cout, rows);
  } else {
    const MachineInfo machine = machine_info();
    std::cout << name << ", lockstep on virtual time, contact every "
              << options.lockstep.contact_period << " ticks, " << options.lockstep.contact_latency
              << " late; version " << machine.version << ", load " << machine.load << "\n";
    print_table(std::cout, rows);
    std::cout << "  hash of all frames " << std::hex << first.hash << std::dec << "\n";
  }
  if (!options.plot.empty()) plot_session(options.plot, name + ", lockstep", first.data);
  if (!all_hold(rows)) throw CLI::RuntimeError(1);
}

}  // namespace

void add_eval_command(CLI::App& app) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app.add_subcommand("eval", "Run a session offline in lockstep and judge it");
  command->add_option("--config", options->config, "session file")->capture_default_str();
  command->add_option("--trace", options->trace, "recorded hand instead of the configured device");
  command->add_option("--for", options->duration, "how long a simulated hand plays [s]")
      ->capture_default_str();
  command
      ->add_option("--contact-period", options->lockstep.contact_period,
                   "servo ticks between two contact steps")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--contact-latency", options->lockstep.contact_latency,
                   "ticks until an answer is visible; 0: within the tick")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_option("--plot", options->plot, "draw force, depth and lateness to this .svg");
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { run_eval(*options); });
}

}  // namespace haptic
