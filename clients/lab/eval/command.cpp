// SPDX-License-Identifier: GPL-3.0-or-later
// hapt eval: the whole chain in lockstep on virtual time, evaluated and repeated bit for bit; or
// one renderer on one mesh, compared with the exact god-object at every tick.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/lab/eval/artefacts.h"
#include "clients/lab/eval/compare/compare.h"
#include "clients/lab/eval/fingerprint.h"
#include "clients/lab/eval/free.h"
#include "clients/lab/eval/moving.h"
#include "clients/lab/eval/quality.h"
#include "clients/lab/eval/renderer.h"
#include "clients/lab/eval/rest.h"
#include "clients/lab/eval/rigid.h"
#include "clients/lab/eval/ruffaldi.h"
#include "clients/lab/eval/slow/slow_contact.h"
#include "clients/lab/eval/table.h"
#include "clients/lab/support/lockstep.h"
#include "clients/report/print_rows.h"
#include "clients/report/session_plot.h"
#include "clients/report/summary.h"
#include "proto/config/command_line.h"
#include "proto/config/config.h"
#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/log/hand_trace.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

struct EvalOptions {
  std::string config = "bunny.toml", trace, plot, forces;
  double duration = 20;
  LockstepOptions lockstep;
  bool json = false, overwrite = false;
  RendererEval renderer;
  std::vector<std::string> meshes;
  std::vector<double> radii{1e-3};  // of the proxy [m]
  std::string protocol, suite;
  std::string compare, output;  // columns, divided by commas
  RuffaldiEval ruffaldi;
  MovingEval moving;
};

struct EvalRun {
  SessionData data;
  Histogram step_time;  // servo + contact + sim in one tick
  uint64_t hash = 0;
};

/// How long the hand plays [s].
double duration_of(const SessionConfig& config, const EvalOptions& options) {
  if (!row_of(config.device.kind).is_recorded) return options.duration;
  return load_hand_trace(config.device.replay).duration();
}

EvalRun run_lockstep(const SessionConfig& config, const ContactShapes& shapes,
                     const EvalOptions& options, Progress& progress) {
  EvalRun run;
  const std::unique_ptr<Device> device = open_device(config.device);
  Lockstep lockstep(config, shapes, *device, options.lockstep);
  const bool replay = row_of(config.device.kind).is_recorded;
  const auto ticks = static_cast<uint64_t>(options.duration * config.servo_rate);
  // a recording is played to its end, a simulated hand for the given duration
  for (uint64_t k = 0; replay || k < ticks; ++k) {
    const int64_t start_ns = now_ns();
    if (!lockstep.step()) break;
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

void run_eval(const EvalOptions& options) {
  const std::string file = find_session_file(options.config);
  SessionConfig config = load_config(file);
  if (!options.trace.empty()) use_trace(config, options.trace);
  if (row_of(config.device.kind).has_node()) {
    throw std::runtime_error(file +
                             ": a real device cannot run on a virtual clock; name a recorded hand "
                             "with --trace, or another --config");
  }
  check_outputs({options.plot}, {options.trace, file}, options.overwrite);
  for (const std::string& line : config_warnings(config))
    std::cerr << one_line(file + ": " + line) << '\n';
  BakeTold told;
  StageProgress baking;
  told.progress = [&](std::string_view stage, double share) { baking.at(stage, share); };
  told.finding = [](const std::string& line) { std::cerr << one_line(line) << '\n'; };
  const BakedSession baked = bake_session(config, told);
  const ContactShapes shapes = baked.shapes();
  EvalRun first, second;
  {
    Progress progress("eval, played twice", 2 * config.servo_rate * duration_of(config, options));
    first = run_lockstep(config, shapes, options, progress);
    second = run_lockstep(config, shapes, options, progress);
  }
  const std::string name(view(config.name));
  Rows rows = machine_rows(name);
  rows.note("lockstep", "virtual time; " + pace_of(options.lockstep));
  std::vector<Row> judged =
      summarize(name, first.data, config, measure_penetration(first.data, config, baked));
  // virtual time has no lateness or busy times, and nothing is recorded
  std::erase_if(judged, [](const Row& row) {
    return (row.unit == "s" && row.metric != kFirstTouch) || row.metric.rfind("samples", 0) == 0;
  });
  rows.append(judged);
  rows.add("one tick, all three steps", first.step_time);
  const bool same = first.hash == second.hash;
  rows.add("repeats that differ, of 1", same ? 0 : 1, "", 0, same);
  char hash[32];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(first.hash));
  rows.note("hash of all frames", hash);

  if (!options.plot.empty()) plot_session(options.plot, name + ", lockstep", first.data);
  print_judged(rows.rows(), options.json);
}

void run_renderer(const EvalOptions& options, const Command& command) {
  EvalTable table{options.renderer, options.meshes, options.radii, {0}};
  table.each.trace = options.trace;
  table.each.plot = options.plot;
  table.each.lockstep.contact_period = options.lockstep.contact_period;
  // by default the answers are not delayed
  if (command.was_given("--contact-latency")) {
    table.latencies = {options.lockstep.contact_latency};
  } else if (options.meshes == std::vector<std::string>{"all"}) {
    table.latencies = {0, 1};
  }
  const std::vector<RendererEval> cases = cases_of(table);
  std::vector<std::string> inputs{options.trace};
  for (const RendererEval& one : cases) {
    if (!is_eval_work(one.mesh)) inputs.push_back(one.mesh);
  }
  check_outputs({options.plot}, inputs, options.overwrite);
  if (cases.size() == 1) {
    print_judged(eval_renderer(cases[0]), options.json);
    return;
  }
  if (!options.plot.empty()) throw std::runtime_error("--plot: draws one case; give one --mesh");
  std::vector<std::vector<Row>> judged;
  for (RendererEval one : cases) {
    one.progress =
        "case " + std::to_string(judged.size() + 1) + " of " + std::to_string(cases.size());
    judged.push_back(eval_renderer(one));
  }
  std::vector<Row> rows;
  for (const auto& one : judged) rows.insert(rows.end(), one.begin(), one.end());
  options.json ? print_json(std::cout, rows) : print_cases(std::cout, judged);
  std::cout.flush();
  if (!all_hold(rows)) throw ExitCode{1};
}

void run_artefacts(const EvalOptions& options) {
  check_outputs({options.plot}, {}, options.overwrite);
  print_judged(eval_artefacts(options.plot), options.json);
}

void run_ruffaldi(const EvalOptions& options) {
  RuffaldiEval eval = options.ruffaldi;
  eval.mesh = options.meshes.empty() ? "" : options.meshes[0];
  eval.size = options.renderer.size;
  eval.lockstep = options.lockstep;
  print_judged(eval_ruffaldi(eval), options.json);
}

void run_rigid_suite(const EvalOptions& options, const Command& command) {
  RigidEval eval;
  if (command.was_given("--for")) eval.ticks = static_cast<uint64_t>(1e3 * options.duration);
  eval.meshes = meshes_folder();
  eval.lockstep = options.lockstep;
  print_judged(eval_rigid(eval), options.json);
}

/// Options common to all evaluations: the hand, its duration and the form of the output.
void add_session_options(Command& command, EvalOptions& options) {
  add_config(command, options.config).show_default();
  command.option("--trace FILE", options.trace, "recorded hand instead of the configured device");
  add_duration(command, "--for", options.duration, "how long a simulated hand explores")
      .show_default();
  command
      .option("--contact-period", options.lockstep.contact_period,
              "servo ticks between two contact steps")
      .range(1, 1000)
      .show_default();
  command
      .option("--contact-latency", options.lockstep.contact_latency,
              "ticks until an answer is visible; 0: within the tick")
      .range(0, 1000)
      .show_default();
  add_plot(command, options.plot);
  add_overwrite(command, options.overwrite);
  add_json(command, options.json);
}

/// Options that compare a renderer with the exact proxy on a mesh instead of running a session.
void add_renderer_options(Command& command, EvalOptions& options) {
  RendererEval& judged = options.renderer;
  command
      .option("--mesh", options.meshes,
              "compare a renderer with the exact answer on these: hf:N, sphere:N, flat:N, a mesh "
              "file, or all for the benchmark set; several make a table")
      .excludes("--config");
  std::map<std::string, Renderer> renderers;
  for (const RendererRow& row : kRenderers) {
    if (!is_of_body(row.id)) renderers.emplace(row.name, row.id);
  }
  command.choice("--renderer", judged.renderer, renderers, "the renderer, of a point")
      .needs("--mesh")
      .show_default("god-object3");
  const auto add = [](Option option) { option.needs("--mesh").show_default(); };
  add(command.quantities("--radius", options.radii, Dimension::kLength, {0, 0.1},
                         "of the proxy of virtual-proxy3, as \"1 mm\"; 0: a point; a number "
                         "without unit is in metres",
                         "m"));
  add(command.number("--friction", judged.friction, {0, 10},
                     "μ of virtual-proxy3, measured on flat:N"));
  add(command.quantity("--size", judged.size, Dimension::kLength, {1e-3, 10},
                       "longest side of a mesh file; a number without unit is in metres", "m"));
  add(command.quantity("--stiffness", judged.stiffness, Dimension::kStiffness, {1, 1e5},
                       "of the coupling; a number without unit is in N/m", "N/m"));
  add(command.quantity("--max-force", judged.max_force, Dimension::kForce, {0.1, 1e3},
                       "limit of the device; a number without unit is in N", "N"));
  add(command.option("--ticks", judged.ticks, "length of the tool's path").range(1, 10'000'000));
}

/// Options of the protocols, which need no session.
void add_protocol_options(Command& command, EvalOptions& options) {
  RuffaldiEval& ruffaldi = options.ruffaldi;
  command
      .option("--protocol", options.protocol,
              "ruffaldi: forces along a probe's trajectory, against the truth; artefacts: what "
              "penalty3 does at an edge and through a thin plate, compared with the proxies")
      .one_of({"ruffaldi", "artefacts"})
      .excludes("--config");
  command
      .option(
          "--suite", options.suite,
          "quality: each 6-DoF renderer in scenes with a known analytic answer; rigid: whole "
          "sessions of those whose tool never enters an object, shaken by a hand, for 4 s or "
          "--for; moving: the same among objects that move, in --scenes scenes with a free "
          "way; free: every renderer without mass in free space, contacts 1 to 20 ticks late; "
          "rest: whether points and spheres come to rest in corners; slow-contact: bodies whose "
          "contacts come at 50 to 1000 Hz, over a ball and past an edge; fingerprint: a hash of "
          "all frames of each session file with each renderer that can play it")
      .one_of({"quality", "rigid", "moving", "free", "rest", "slow-contact", "fingerprint"})
      .excludes("--config")
      .excludes("--protocol")
      .excludes("--mesh");
  command
      .option("--forces FOLDER", options.forces,
              "of --suite fingerprint: keeps the forces of one build here and prints the largest "
              "difference of the next one")
      .needs("--suite");
  command
      .option("--compare COLUMNS", options.compare,
              "one hand through several renderers in lockstep: names divided by commas, with a "
              "solver where they have some, as god-object6,voxel/quasi-static")
      .excludes("--mesh")
      .excludes("--protocol")
      .excludes("--suite");
  command
      .option("-o,--output FILE.mcap", options.output,
              "of --compare: a recording with the topics of each renderer; no clock is in it, the "
              "same comparison is the same file")
      .needs("--compare");
  command.option("--scenes", options.moving.scenes, "how many, of --suite moving")
      .needs("--suite")
      .range(1, 1'000'000)
      .show_default();
  command.option("--surface", ruffaldi.surface, "plane, sphere, torus or bumpy")
      .needs("--protocol")
      .one_of({"plane", "sphere", "torus", "bumpy"})
      .show_default();
  command
      .quantity("--noise", ruffaldi.noise, Dimension::kLength, {0, 1e-3},
                "of the tracker, σ; a number without unit is in metres", "m")
      .needs("--protocol")
      .show_default();
  command.option("--traj FILE", ruffaldi.traj, "a scan instead of a surface, of the mesh --mesh")
      .needs("--protocol")
      .needs("--mesh");
}

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream in(list);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

void run_compare(const EvalOptions& options) {
  const std::string file = find_session_file(options.config);
  CompareEval eval;
  eval.config = load_config(file);
  eval.config_text = read_config_text(file);
  eval.columns = words_of(options.compare);
  eval.output = options.output;
  eval.lockstep = options.lockstep;
  eval.seconds = options.duration;
  if (!options.trace.empty()) use_trace(eval.config, options.trace);
  if (row_of(eval.config.device.kind).has_node()) {
    throw std::runtime_error(file +
                             ": a real device cannot run on a virtual clock; name a "
                             "recorded hand with --trace, or another --config");
  }
  check_outputs({options.output}, {options.trace, file}, options.overwrite);
  const std::vector<CompareFigures> figures = compare_renderers(eval);
  const std::vector<Row> rows = rows_of(figures, eval);
  options.json ? print_json(std::cout, rows) : print_comparison(std::cout, figures, eval);
  std::cout.flush();
  if (!all_hold(rows)) throw ExitCode{1};
}

/// All session files beside the default one.
void run_fingerprint(const EvalOptions& options, const Command& command) {
  namespace fs = std::filesystem;
  FingerprintEval eval{{}, 4, options.lockstep, options.forces};
  for (const auto& entry :
       fs::directory_iterator(fs::path(find_session_file("bunny.toml")).parent_path())) {
    if (entry.path().extension() == ".toml") eval.configs.push_back(entry.path());
  }
  std::sort(eval.configs.begin(), eval.configs.end());
  if (command.was_given("--for")) eval.seconds = options.duration;
  print_judged(eval_fingerprint(eval), options.json);
}

void run_suite(EvalOptions& options, const Command& command) {
  const std::string& suite = options.suite;
  if (suite == "fingerprint") return run_fingerprint(options, command);
  if (suite == "rigid") return run_rigid_suite(options, command);
  if (suite == "quality") return print_judged(eval_quality(QualityGrain{}), options.json);
  if (suite == "free") return print_judged(eval_free({}), options.json);
  if (suite == "slow-contact") return print_judged(eval_slow_contact({}), options.json);
  if (suite == "rest") return print_judged(eval_rest(RestEval{}), options.json);
  options.moving.lockstep = options.lockstep;
  print_judged(eval_moving(options.moving), options.json);
}

}  // namespace

void add_eval_command(Command& app) {
  const auto options = std::make_shared<EvalOptions>();
  Command command = add_elsewhere(app, "eval");
  add_session_options(command, *options);
  add_renderer_options(command, *options);
  add_protocol_options(command, *options);
  command.example("hapt eval --trace hand.csv --plot hand.svg");
  command.action([options, command] {
    if (!options->compare.empty()) return run_compare(*options);
    if (!options->suite.empty()) {
      run_suite(*options, command);
      return;
    }
    if (!options->protocol.empty()) {
      options->protocol == "ruffaldi" ? run_ruffaldi(*options) : run_artefacts(*options);
      return;
    }
    options->meshes.empty() ? run_eval(*options) : run_renderer(*options, command);
  });
}

}  // namespace haptic
