// SPDX-License-Identifier: GPL-3.0-or-later
// hapt eval: the whole chain in lockstep on virtual time, evaluated and repeated bit for bit; or a
// suite of scenes.
#include <array>
#include <iostream>
#include <memory>
#include <optional>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/report/session_plot.h"
#include "clients/report/summary.h"
#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/log/hand_trace.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"

namespace haptic {

#define SUITE(name, help) Prepare suite_##name;
#include "clients/lab/eval/suites.def"

namespace {

const std::array kSuites{
#define SUITE(name, help) Measurement{#name, help, suite_##name},
#include "clients/lab/eval/suites.def"
};

struct EvalOptions {
  OfflineSession session;
  std::string plot;
  bool overwrite = false;
};

struct EvalRun {
  SessionData data;
  Histogram step_time;  // servo + contact + sim in one tick
  uint64_t hash = 0;
};

EvalRun run_lockstep(const SessionConfig& config, const ContactShapes& shapes,
                     const OfflineSession& session, Progress& progress) {
  EvalRun run;
  const std::unique_ptr<Device> device = open_device(config.device);
  Lockstep lockstep(config, shapes, *device, session.lockstep);
  std::optional<GivenInLockstep> given;
  if (!session.without_clients) given.emplace(config);
  const uint64_t ticks = ticks_of(config, session.seconds);
  for (uint64_t k = 0; k < ticks; ++k) {
    const int64_t start_ns = now_ns();
    if (given ? !given->step(lockstep) : !lockstep.step()) break;
    progress.step();
    run.step_time.add(now_ns() - start_ns);
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

/// The file's warnings on standard error, and its shapes with progress.
BakedSession bake_told(const SessionConfig& config, const std::string& file) {
  for (const std::string& line : config_warnings(config))
    std::cerr << one_line(file + ": " + line) << '\n';
  BakeTold told;
  StageProgress baking;
  told.progress = [&](std::string_view stage, double share) { baking.at(stage, share); };
  told.finding = [](const std::string& line) { std::cerr << one_line(line) << '\n'; };
  return bake_session(config, told);
}

void eval_session(const EvalOptions& options, const Rows& all) {
  const OfflineSession& session = options.session;
  const SessionConfig config = session.load();
  check_outputs({options.plot}, {session.trace, session.file()}, options.overwrite);
  const BakedSession baked = bake_told(config, session.file());
  const ContactShapes shapes = baked.shapes();
  const double seconds = row_of(config.device.kind).is_recorded
                             ? load_hand_trace(config.device.replay).duration()
                             : session.seconds;
  EvalRun first, second;
  {
    Progress progress("eval, played twice", 2 * config.servo_rate * seconds);
    first = run_lockstep(config, shapes, session, progress);
    second = run_lockstep(config, shapes, session, progress);
  }
  const std::string name(view(config.name));
  Rows rows = all.machine(name);
  rows.note("lockstep", "virtual time; " + pace_of(session.lockstep));
  std::vector<Row> judged =
      summarize(name, first.data, config, measure_penetration(first.data, config, baked));
  // virtual time has no lateness or busy times, and nothing is recorded
  std::erase_if(judged, [](const Row& row) {
    return (row.unit == "s" && row.metric != kFirstTouch) || row.metric.rfind("samples", 0) == 0;
  });
  rows.append(judged);
  rows.add("one tick, all three steps", first.step_time);
  const bool same = first.hash == second.hash;
  rows.add("repeats that differ, of 1", same ? 0 : 1, "", given(0, same));
  rows.note("hash of all frames", in_hex(first.hash));
  if (!options.plot.empty()) plot_session(options.plot, name + ", lockstep", first.data);
}

/// `hapt eval` without a suite.
Measured prepare_session(Command& command) {
  const auto options = std::make_shared<EvalOptions>();
  add_offline_session(command, options->session);
  command.flag("--without-clients", options->session.without_clients,
               "leave out what clients gave in the recording of the hand");
  add_plot(command, options->plot);
  add_overwrite(command, options->overwrite);
  return measured(eval_session, options);
}

}  // namespace

void add_eval_command(Command& app) {
  Command command = add_elsewhere(app, "eval");
  command.footer("Without a suite it plays a session; a suite has options of its own.");
  add_measurements(command, "hapt eval", kSuites);
  measure_by(command, prepare_session, "hapt eval --trace hand.csv --plot hand.svg");
  command.exclude_subcommands();
}

}  // namespace haptic
