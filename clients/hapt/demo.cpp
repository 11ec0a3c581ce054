// SPDX-License-Identifier: GPL-3.0-or-later
// hapt demo and hapt replay: run a session, record and evaluate it.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/hand_progress.h"
#include "clients/hapt/mesh_scene.h"
#include "clients/hapt/options.h"
#include "clients/hapt/realtime_line.h"
#include "clients/hapt/scenes.h"
#include "clients/hapt/scratch_folder.h"
#include "clients/hapt/session_process.h"
#include "clients/library/given_player.h"
#include "clients/library/recorder.h"
#include "clients/log/trace_writer.h"
#include "clients/report/session_plot.h"
#include "clients/report/summary.h"
#include "clients/report/verdict.h"
#include "contact/bake/reach.h"
#include "proto/config/command_line.h"
#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/config/read/config_shape.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/log/hand_trace.h"
#include "proto/log/trace.h"
#include "proto/os/message.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

constexpr int64_t kDrainPeriod = 10'000'000;           // [ns]
constexpr int64_t kStartPatience = 10 * kNsPerSecond;  // [ns]; until hapticd answers
constexpr double kNoNewsLimit = 10;    // [s]; a session silent for longer has failed
constexpr int kExitInterrupted = 130;  // 128 + SIGINT

struct PlayOptions {
  std::string config = "bunny.toml", renderer, session, log, plot;
  ReplayChoice replay;
  std::string from, to;  // a time or a tick
  double limit = std::numeric_limits<double>::infinity();
  std::string title, next = "hapt demo --list";  // of the last line
  std::string script;                            // of Python, that gives to the session
  double duration = 20, standard_rate = kStandardRate;
  bool json = false, overwrite = false, report = false, verbose = false, view = false;
  bool without_clients = false;  // what clients gave in the recording is left out
};

/// Observations of the recorder while the session ran.
struct Played {
  std::string realtime;
  uint64_t lost = 0;
  bool ended_early = false;
  bool was_cut = false;  // ended before the recorded hand has
  std::string given;     // why not all was given that clients had given; "": it was
};

/// A recorded hand, sampled on the servo's grid.
struct Recording {
  size_t samples = 0;
  double seconds = 0;  // that it lasts, as far as it is played
  double limit = 0;    // end after [s]: one that is not cut says itself when it has ended
};

std::string default_log(const std::string& session) {
  char stamp[32];
  const std::time_t now = std::time(nullptr);
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  return session + "-" + stamp + ".mcap";
}

void stop_where_asked() {
  if (!stop_requested()) return;
  std::cerr << "hapt: stopped before the session began\n";
  throw ExitCode{kExitInterrupted};
}

BakedSession bake_all(const SessionConfig& config) {
  BakeTold told;
  told.begin = [](const std::string& mesh) {
    stop_where_asked();
    std::cerr << "reading and checking " << shown(std::filesystem::path(mesh).filename().string())
              << '\n';
  };
  StageProgress progress;
  told.progress = [&](std::string_view stage, double share) {
    progress.at(stage, share);
    stop_where_asked();
  };
  told.finding = [](const std::string& line) { std::cerr << "  " << one_line(line) << '\n'; };
  BakedSession baked = bake_session(config, told);
  stop_where_asked();
  return baked;
}

/// Prints the log of hapticd, which explains why a session did not start.
void show_log(const std::string& path) {
  std::ifstream log(path);
  if (log.peek() != std::ifstream::traits_type::eof()) std::cerr << log.rdbuf();
}

/// Connects to the session of this hapticd and rejects another one of the same name.
FileDescriptor connect_when_ready(SessionProcess& daemon, const std::string& session,
                                  const std::string& said) {
  for (const int64_t start = now_ns();; sleep_until(now_ns() + kDrainPeriod)) {
    stop_where_asked();
    if (const auto code = daemon.exit_code()) {
      show_log(said);
      // its message is above
      std::cerr << "hapt: hapticd ended before the session was up\n";
      throw ExitCode{std::max(*code, kExitFailed)};
    }
    try {
      FileDescriptor socket = connect_session(session);
      if (peer_of(socket).hapticd == daemon.pid()) return socket;
    } catch (const HandoutError&) {
      if (now_ns() - start > kStartPatience) throw;
    }
  }
}

/// The exit code of a script whose session has ended, which it is given a while to see.
int ended(SessionProcess& script) {
  const int64_t give_up_ns = now_ns() + 2 * kNsPerSecond;
  while (!script.exit_code() && now_ns() < give_up_ns) sleep_until(now_ns() + kDrainPeriod);
  return script.stop();
}

/// Watches and records until the hand has finished, or the session ends early. The last frame of
/// the servo.
ServoFrame record_hand(const Recording& hand, bool replay, SessionProcess& daemon,
                       RingSource<&ServoChannels::frames>& watched, Recorder& recorder,
                       TraceWriter& trace, Played& played) {
  HandProgress progress(hand.seconds);
  ServoFrame frame{};
  double shown = 0;
  int64_t first_ns = 0, news_ns = now_ns();
  for (bool done = false; !done;) {
    sleep_until(now_ns() + kDrainPeriod);
    if (!recorder.drain(trace, now_ns())) break;
    while (watched.next(frame)) {
      if (first_ns == 0) first_ns = frame.t_ns;
      news_ns = now_ns();
      shown = static_cast<double>(frame.t_ns - first_ns) * 1e-9;
      progress.add(frame);
    }
    progress.show(shown, now_ns());
    // baking before the first frame may take arbitrarily long
    const bool silent =
        first_ns != 0 && static_cast<double>(now_ns() - news_ns) * 1e-9 > kNoNewsLimit;
    played.ended_early = stop_requested() || daemon.exit_code().has_value() || silent;
    const bool played_out = (replay && (frame.device.flags & kDeviceEnded) != 0) ||
                            (first_ns != 0 && shown >= hand.limit);
    done = played_out || played.ended_early;
  }
  return frame;
}

/// Records until the hand has finished, then stops the session and drains the rest.
Played play_and_record(const PlayOptions& options, const SessionConfig& config,
                       const Recording& hand, std::unique_ptr<GivenReplay> given) {
  const bool replay = row_of(config.device.kind).is_recorded;
  std::vector<std::string> arguments{options.config, "--session", options.session};
  for (std::string& word : replay_options(options.replay)) arguments.push_back(std::move(word));
  if (!options.renderer.empty()) {
    arguments.insert(arguments.end(), {"--renderer", options.renderer});
  }
  const ScratchFolder scratch;
  const std::string said = options.verbose ? "" : scratch.path() + "/hapticd.log";
  SessionProcess daemon("hapticd", arguments, said);
  FileDescriptor socket = connect_when_ready(daemon, options.session, said);
  // it says where, and opens a browser
  std::optional<SessionProcess> bridge;
  if (options.view)
    bridge.emplace("haptic-view", std::vector<std::string>{"view", options.session});
  EyeBook eyes;
  Attachments attachments(std::move(socket), eyes.options());
  Recorder recorder(attachments, Start::kOldest, options.standard_rate);
  recorder.follow(eyes);
  recorder.set_base(load_config(options.config).map.X_WB);
  auto watched = attachments.ring<&ServoChannels::frames>(Start::kOldest);
  attachments.start();
  std::optional<SessionProcess> script;
  const std::string script_said = scratch.path() + "/script.log";
  if (!options.script.empty()) {
    script.emplace(kPython, std::vector{options.script, options.session}, script_said);
  }
  std::optional<GivenPlayer> giver;
  if (given != nullptr) giver.emplace(options.session, config, std::move(given));
  TraceWriter trace(options.log,
                    recording_metadata(options.session, read_config_text(options.config)));

  Played played;
  const ServoFrame frame = record_hand(hand, replay, daemon, watched, recorder, trace, played);
  played.was_cut = (frame.device.flags & kDeviceEnded) == 0;
  const bool has_crashed = daemon.exit_code().value_or(0) != 0;
  if (giver) {
    giver->end();
    played.given = giver->problem();
  }
  daemon.stop();
  if (script && ended(*script) != 0) {
    show_log(script_said);
    played.given = options.script + " ended with an error, see above";
  }
  if (has_crashed) show_log(said);
  const bool finished = recorder.finish(trace, now_ns());
  for (const TopicCount& count : recorder.counts()) played.lost += count.lost;
  played.realtime = realtime_line(recorder.servo_header());
  if (!finished) throw std::runtime_error(recorder.failure());
  return played;
}

/// Checks that every grid point of the recorded hand was either played or counted as skipped.
void add_coverage_rows(const SessionData& data, const Recording& hand, double rate, Rows& rows) {
  if (data.frames.empty() || !std::isfinite(hand.seconds)) return;
  const auto is_ended = [](const ServoFrame& f) { return (f.device.flags & kDeviceEnded) != 0; };
  const size_t n = data.frames.size();
  size_t end = 0;
  while (end < n && !is_ended(data.frames[end])) ++end;
  const ServoFrame first = data.frames.front();
  const ServoFrame last = data.frames[std::min(end, n - 1)];
  const ServoFrame before = end == 0 ? first : data.frames[end - 1];
  const double grid_points = std::floor((hand.seconds + 1e-9 * kSnapNs) * rate + 1e-6) + 1;
  // ticks skipped after the end of the recording lose none of its samples
  const double beyond = std::clamp(static_cast<double>(last.tick - first.tick) - grid_points, 0.0,
                                   static_cast<double>(last.skipped - before.skipped));
  const double total =
      static_cast<double>(end) + static_cast<double>(last.skipped - first.skipped) - beyond;
  rows.add("samples of the recorded hand", static_cast<double>(hand.samples), "");
  rows.add("frames plus counted skips", total, "", given(grid_points, total == grid_points));
}

/// A time, or a tick of the recording, from its first sample [s]; none if there is none.
std::optional<double> instant_of(const std::string& option, const std::string& text,
                                 const HandTrace& trace) {
  if (text.empty()) return std::nullopt;
  if (text.find_first_not_of("0123456789") == std::string::npos) {
    return trace.time_of(std::strtoull(text.c_str(), nullptr, 10));
  }
  try {
    return parse_quantity(text, Dimension::kTime, kNotNegative);
  } catch (const QuantityError& error) {
    throw UsageError(option + ": " + error.what());
  }
}

/// The time that a part of a recording takes to play [s].
double played_time(const ReplayConfig& replay, double duration) {
  const double end = replay.to > 0 ? std::min(replay.to, duration) : duration;
  return (end - replay.from) / replay.speed;
}

/// The kind of hand, stated so that no kind is mistaken for another.
std::string hand_line(const DeviceConfig& device) {
  const DeviceRow& row = row_of(device.kind);
  if (row.is_recorded && device.replay.closed_loop != 0) {
    return "SIMULATED hand, closed loop, with the intention of " +
           std::string(view(device.replay.path));
  }
  if (row.is_recorded) {
    return "RECORDED hand " + std::string(view(device.replay.path)) +
           ", open loop: force has no effect";
  }
  if (row.has_node()) {
    return std::string(row.name) + " at " + std::string(view(device.serial.path)) + ", closed loop";
  }
  return "SIMULATED " + std::string(row.simulates) + ", seed " + std::to_string(device.hand.seed) +
         ", closed loop";
}

/// The table: hand and machine, the figures with their goals, and the log's name.
std::vector<Row> judge(const PlayOptions& options, const SessionConfig& config,
                       const BakedSession& baked, const Recording& hand, const Played& played,
                       const SessionData& data) {
  Rows rows(options.session);
  rows.note("hand", hand_line(config.device));
  rows.note("machine", machine_line());
  rows.note("real time", played.realtime);
  rows.append(summarize(options.session, data, config, measure_penetration(data, config, baked)));
  // a hand in closed loop lives in the time of its wakes, and meets no sample of its intention
  const bool is_open = config.device.replay.closed_loop == 0;
  if (row_of(config.device.kind).is_recorded && is_open && !played.was_cut)
    add_coverage_rows(data, hand, config.servo_rate, rows);
  rows.note("log", options.log);
  if (!options.plot.empty()) rows.note("plot", options.plot);
  return rows.rows();
}

/// The last line of a run; where standard output is JSON, a failure is told on standard error.
void end_with(const PlayOptions& options, const std::string& line, bool passed) {
  if (!options.json) {
    std::cout << line << '\n';
  } else if (!passed) {
    std::cerr << line << '\n';
  }
  std::cout.flush();
  if (!passed) throw ExitCode{kExitFailed};
}

void print_rows(const PlayOptions& options, const SessionConfig& config,
                const std::vector<Row>& rows) {
  if (options.json) return print_json(std::cout, rows);
  std::cout << "session '" << shown(options.session) << "', " << hand_line(config.device) << '\n';
  print_table(std::cout, options.report ? rows : brief(rows));
}

/// Finds what clients gave in the recording that is played; null: nothing.
std::unique_ptr<GivenReplay> given_in(const PlayOptions& options, const SessionConfig& config) {
  const ReplayConfig& replay = config.device.replay;
  const std::string path(view(replay.path));
  if (options.without_clients || !is_mcap_file(path)) return nullptr;
  auto given = std::make_unique<GivenReplay>(path, config, replay.from);
  if (given->is_empty()) return nullptr;
  if (replay.speed != 1 || replay.loop != 0) {
    throw UsageError("--speed, --loop: " + shown(path) +
                     " has what clients gave, which plays once and at speed 1; leave them out: "
                     "--without-clients");
  }
  return given;
}

void play(PlayOptions options) {
  catch_stop_signals();
  // before time goes into a mesh
  if (options.view) program_path("haptic-view");
  program_path("hapticd");
  options.config = find_session_file(options.config);
  SessionConfig config = load_config(options.config);
  if (!options.replay.trace.empty()) use_trace(config, options.replay.trace);
  if (!options.renderer.empty()) use_renderer(config, options.renderer);
  if (options.session.empty()) options.session = std::string(view(config.name));
  if (options.log.empty()) options.log = default_log(options.session);
  const bool replay = row_of(config.device.kind).is_recorded;
  check_outputs({options.log, options.plot},
                {options.config, replay ? std::string(view(config.device.replay.path)) : ""},
                options.overwrite);
  Recording hand{0, options.duration, options.duration};
  if (replay) {
    const HandTrace trace = load_hand_trace(config.device.replay);
    options.replay.from = instant_of("--from", options.from, trace);
    options.replay.to = instant_of("--to", options.to, trace);
    use_replay(config, options.replay);
    hand.samples = trace.samples.size();
    hand.seconds = played_time(config.device.replay, trace.duration());
    const bool is_looped = config.device.replay.loop != 0;
    if (is_looped) hand.seconds = options.duration;
    hand.seconds = std::min(hand.seconds, options.limit);
    hand.limit = is_looped ? hand.seconds : options.limit;
    if (!trace.notice.empty()) {
      std::cerr << shown(view(config.device.replay.path)) << ": " << trace.notice << '\n';
    }
  }

  std::unique_ptr<GivenReplay> given = replay ? given_in(options, config) : nullptr;
  // baked here once: contact then finds it in the cache, and the evaluation needs it too
  const BakedSession baked = bake_all(config);
  if (nothing_in_reach(config, baked)) {
    end_with(options, verdict({}, "", 0, out_of_reach(config, baked, 0), ""), false);
  }
  const Played played = play_and_record(options, config, hand, std::move(given));
  SessionData data = load_session(options.log);
  data.lost = played.lost;
  const std::vector<Row> rows = judge(options, config, baked, hand, played, data);
  print_rows(options, config, rows);
  if (!options.plot.empty()) plot_session(options.plot, "session " + options.session, data);
  const std::string trouble =
      played.ended_early ? "the session ended early; what was recorded is in " + options.log
      : played.given.empty()
          ? ""
          : "what clients gave could not all be given: " + one_line(played.given);
  if (options.title.empty()) options.title = "session '" + options.session + "'";
  end_with(options, verdict(rows, options.title, hand.seconds, trouble, options.next),
           trouble.empty() && all_hold(rows));
}

void play_mesh(PlayOptions options, const OwnMesh& own) {
  if (own.size == 0 && (own.unit.empty() || own.unit == "any")) {
    throw UsageError(
        "--mesh: a mesh file has no unit; add --unit mm (or m, cm, in), or scale it: --size "
        "\"80 mm\"");
  }
  const ScratchFolder scratch;
  options.config = scratch.path() + "/" + name_of(own) + ".toml";
  std::ofstream(options.config) << session_text(own);
  options.title = shown(std::filesystem::path(own.file).filename().string());
  options.next = "hapt bake " + shown(own.file) + (own.size > 0 ? "" : " --unit " + own.unit);
  play(options);
}

/// The session file inside a recording; empty: it has none.
std::string config_inside(const std::string& trace) {
  if (!trace.ends_with(".mcap")) return "";
  const TraceReader reader(trace);
  const auto& all = reader.mcap().metadata();
  const auto recording = all.find("recording");
  if (recording == all.end()) return "";
  const auto config = recording->second.find("config");
  return config == recording->second.end() ? "" : config->second;
}

/// Plays a hand in the session in which it was recorded.
void play_as_recorded(PlayOptions options) {
  const std::string inside = config_inside(options.replay.trace);
  if (inside.empty()) {
    std::error_code unknown;  // what is no file is refused in one line when it is read
    if (std::filesystem::is_regular_file(options.replay.trace, unknown)) {
      std::cerr << shown(options.replay.trace) << " has no session file inside: playing "
                << options.config << "; --config names another\n";
    }
    return play(options);
  }
  const ScratchFolder scratch;
  options.config = scratch.path() + "/recorded.toml";
  std::ofstream(options.config) << inside;
  std::cerr << "playing the session inside " << shown(options.replay.trace)
            << "; --config names another\n";
  play(options);
}

void add_common(Command& command, PlayOptions& options) {
  command
      .option("--renderer", options.renderer, "instead of the session file's: " + renderer_names())
      .show_default("the session file's");
  command.option("--session", options.session, "name to run under")
      .show_default("the session file's");
  command.option("-o,--output FILE.mcap", options.log, "recording to write")
      .show_default("the session's name and the time");
  add_standard_rate(command, options.standard_rate);
  add_plot(command, options.plot);
  add_overwrite(command, options.overwrite);
  command.flag("--report", options.report, "print every figure");
  command.flag("--verbose", options.verbose, "show the log of hapticd meanwhile");
  add_json(command, options.json);
}

}  // namespace

void add_demo_command(Command& app) {
  const auto options = std::make_shared<PlayOptions>();
  Command command =
      app.subcommand("demo", "Run a simulated hand on a mesh, record it and print a report");
  add_config(command, options->config).show_default();
  add_common(command, *options);
  const auto scene = std::make_shared<std::string>();
  command
      .option("SCENE", *scene,
              "bunny: a point on a mesh; peg, gears, teeth, ball-joint, dimpled-ball, bunnies: "
              "bodies that push and turn; rigid-peg, rigid-bunnies, frame: bodies that never "
              "enter another; heap, door, gear-pair, gearshift: objects that give way; robot, "
              "field: what a Python script computes; admittance: an arm that is led")
      .one_of(scene_names())
      .excludes("--config")
      .show_default("bunny");
  command.option("--trace FILE", options->replay.trace,
                 "recorded hand (.mcap or .csv) instead of the simulated one");
  add_duration(command, "--for", options->duration, "how long the hand explores")
      .show_default("20 s, or as long as a recorded hand lasts");
  const auto own = std::make_shared<OwnMesh>();
  command
      .option("--mesh FILE", own->file,
              "a mesh of your own (OBJ, STL, PLY, OFF) instead of a scene")
      .excludes("--config")
      .excludes("SCENE");
  command.option("--unit UNIT", own->unit, "of the mesh: mm, m, cm, in, or a length as \"25.4 mm\"")
      .check(problem_of_unit)
      .needs("--mesh");
  command
      .quantity("--size LENGTH", own->size, Dimension::kLength, kMeshSizes,
                "scale the mesh: its longest side, as \"80 mm\"; a number alone: metres", "m")
      .needs("--mesh");
  command.flag("--allow-open", own->allow_open, "the mesh may have borders").needs("--mesh");
  command.flag("--view", options->view, "show it in a browser meanwhile").excludes("--json");
  const auto list = std::make_shared<bool>(false);
  command.flag("--list", *list, "list the scenes");
  options->without_clients = true;  // the hand alone
  command.example("hapt demo --mesh part.stl --unit mm");
  command.action([options, scene, own, list, command] {
    if (*list) return list_scenes(std::cout);
    if (command.was_given("--for")) options->limit = options->duration;
    if (!own->file.empty()) return play_mesh(*options, *own);
    if (scene->empty() && !command.was_given("--config")) *scene = default_scene();
    if (!scene->empty()) {
      options->config = prepare_scene(*scene);
      options->title = scene_title(*scene);
      options->script = scene_script(*scene);
    }
    play(*options);
  });
}

void add_replay_command(Command& app) {
  const auto options = std::make_shared<PlayOptions>();
  options->duration = options->limit;  // a loop goes on until --for or Ctrl-C
  Command command = app.subcommand(
      "replay", "Play a recorded hand through a session, open loop or as an intention");
  command.option("TRACE", options->replay.trace, "recorded hand: .mcap or .csv").required();
  add_config(command, options->config)
      .show_default("the one inside the recording, else bunny.toml");
  command.number("--speed", options->replay.speed, kReplaySpeeds, "of the playback")
      .show_default("1");
  const std::string instant = "a time from the first sample, as 2.5s, or the number of a tick";
  command.option("--from INSTANT", options->from, "where to begin: " + instant);
  command.option("--to INSTANT", options->to, "where to end: " + instant);
  command.flag("--loop", options->replay.loop,
               "again and again until Ctrl-C or --for; without force while the hand returns");
  add_duration(command, "--for", options->limit, "end after").show_default("the end of the hand");
  command.flag("--closed-loop", options->replay.closed_loop,
               "the recorded hand is the intention of the simulated hand, which forces push back");
  command
      .quantity("--stiffness", options->replay.stiffness, Dimension::kStiffness, kPositive,
                "of the coupling, as \"500 N/m\"; a number without unit is in N/m", "N/m")
      .show_default("the session file's");
  command.flag("--without-clients", options->without_clients,
               "leave out what clients gave in the recording");
  add_common(command, *options);
  command.example("hapt replay hand.csv --config plane.toml --speed 0.5");
  command.action([options, command] {
    command.was_given("--config") ? play(*options) : play_as_recorded(*options);
  });
}

}  // namespace haptic
