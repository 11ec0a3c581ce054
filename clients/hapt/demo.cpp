// SPDX-License-Identifier: GPL-3.0-or-later
// hapt demo and hapt replay: run a session, record and evaluate it.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <memory>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/find_config.h"
#include "clients/hapt/options.h"
#include "clients/hapt/realtime_line.h"
#include "clients/hapt/scenes.h"
#include "clients/hapt/session_process.h"
#include "clients/library/recorder.h"
#include "clients/report/session_plot.h"
#include "clients/report/summary.h"
#include "proto/config/command_line.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/process.h"
#include "proto/log/hand_trace.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kDrainPeriod = 10'000'000;           // [ns]
constexpr int64_t kProgressPeriod = kNsPerSecond / 4;  // [ns]
constexpr int64_t kStartPatience = 10 * kNsPerSecond;  // [ns]; until hapticd answers
constexpr double kNoNewsLimit = 10;    // [s]; a session silent for longer has failed
constexpr int kExitInterrupted = 130;  // 128 + SIGINT

struct PlayOptions {
  std::string config = "bunny.toml", renderer, session, trace, log, plot;
  double duration = 20;
  bool json = false, overwrite = false;
};

/// Observations of the recorder while the session ran.
struct Played {
  std::string realtime;
  uint64_t lost = 0;
  bool ended_early = false;
};

/// A recorded hand, sampled on the servo's grid.
struct Recording {
  size_t samples = 0;
  double seconds = 0;
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
    std::cerr << "reading and checking " << shown(mesh) << '\n';
  };
  told.finding = [](const std::string& line) { std::cerr << "  " << one_line(line) << '\n'; };
  BakedSession baked = bake_session(config, told);
  stop_where_asked();
  return baked;
}

/// A line that overwrites itself on a terminal and is printed every five seconds elsewhere.
class Progress {
 public:
  explicit Progress(double total) : total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}
  ~Progress() {
    if (terminal_ && shown_) std::fputs("\r\033[K", stderr);
  }
  void show(const ServoFrame& frame, double seconds, int64_t t_ns) {
    if (t_ns - last_ns_ < (terminal_ ? kProgressPeriod : 20 * kProgressPeriod)) return;
    last_ns_ = t_ns;
    shown_ = true;
    std::fprintf(stderr, "%s%5.1f of %.0f s   force %5.2f N   depth %5.2f mm   late ticks %llu%s",
                 terminal_ ? "\r" : "", seconds, total_, norm(frame.F_device_B.f),
                 1e3 * frame.depth, static_cast<unsigned long long>(frame.skipped),
                 terminal_ ? "\033[K" : "\n");
  }

 private:
  double total_;
  bool terminal_, shown_ = false;
  int64_t last_ns_ = now_ns();
};

/// Connects to the session of this hapticd and rejects another one of the same name.
FileDescriptor connect_when_ready(SessionProcess& daemon, const std::string& session) {
  for (const int64_t start = now_ns();; sleep_until(now_ns() + kDrainPeriod)) {
    stop_where_asked();
    if (const auto code = daemon.exit_code()) {
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

/// Records until the hand has finished, then stops the session and drains the rest.
Played play_and_record(const PlayOptions& options, bool replay, double seconds) {
  std::vector<std::string> arguments{options.config, "--session", options.session};
  if (!options.trace.empty()) arguments.insert(arguments.end(), {"--replay", options.trace});
  if (!options.renderer.empty()) {
    arguments.insert(arguments.end(), {"--renderer", options.renderer});
  }
  SessionProcess daemon(arguments);
  Attachments attachments(connect_when_ready(daemon, options.session));
  Recorder recorder(attachments, Start::kOldest);
  auto watched = attachments.ring<&ServoChannels::frames>(Start::kOldest);
  attachments.start();
  TraceWriter trace(options.log,
                    recording_metadata(options.session, read_config_text(options.config)));

  Played played;
  Progress progress(seconds);
  ServoFrame frame{};
  double shown = 0;
  int64_t first_ns = 0, news_ns = now_ns();
  for (bool done = false; !done;) {
    sleep_until(now_ns() + kDrainPeriod);
    if (!recorder.drain(trace, now_ns())) break;
    if (watched.latest(frame)) {
      if (first_ns == 0) first_ns = frame.t_ns;
      news_ns = now_ns();
      shown = static_cast<double>(frame.t_ns - first_ns) * 1e-9;
      progress.show(frame, shown, news_ns);
    }
    // baking before the first frame may take arbitrarily long
    const bool silent =
        first_ns != 0 && static_cast<double>(now_ns() - news_ns) * 1e-9 > kNoNewsLimit;
    played.ended_early = stop_requested() || daemon.exit_code().has_value() || silent;
    const bool played_out =
        replay ? (frame.device.flags & kDeviceEnded) != 0 : first_ns != 0 && shown >= seconds;
    done = played_out || played.ended_early;
  }
  daemon.stop();
  const bool finished = recorder.finish(trace, now_ns());
  for (const TopicCount& count : recorder.counts()) played.lost += count.lost;
  played.realtime = realtime_line(recorder.servo_header());
  if (!finished) throw std::runtime_error(recorder.failure());
  return played;
}

/// Checks that every grid point of the recorded hand was either played or counted as skipped.
void add_coverage_rows(const SessionData& data, const Recording& hand, double rate, Rows& rows) {
  if (data.frames.empty()) return;
  const auto is_ended = [](const ServoFrame& f) { return (f.device.flags & kDeviceEnded) != 0; };
  const auto end = std::find_if(data.frames.begin(), data.frames.end(), is_ended);
  const ServoFrame& first = data.frames.front();
  const ServoFrame& last = end == data.frames.end() ? data.frames.back() : *end;
  const ServoFrame& before = end == data.frames.begin() ? first : *(end - 1);
  const double grid_points = std::floor((hand.seconds + 1e-9 * kSnapNs) * rate + 1e-6) + 1;
  // ticks skipped after the end of the recording lose none of its samples
  const double beyond = std::clamp(static_cast<double>(last.tick - first.tick) - grid_points, 0.0,
                                   static_cast<double>(last.skipped - before.skipped));
  const double total = static_cast<double>(end - data.frames.begin()) +
                       static_cast<double>(last.skipped - first.skipped) - beyond;
  rows.add("samples of the recorded hand", static_cast<double>(hand.samples), "");
  rows.add("frames plus counted skips", total, "", grid_points, total == grid_points);
}

/// The kind of hand, stated so that no kind is mistaken for another.
std::string hand_line(const DeviceConfig& device) {
  const DeviceRow& row = row_of(device.kind);
  if (row.is_recorded) {
    return "RECORDED hand " + std::string(view(device.replay.path)) +
           ", open loop: force has no effect";
  }
  if (row.has_node) {
    return std::string(row.name) + " at " + std::string(node_of(device)) + ", closed loop";
  }
  return "SIMULATED hand, seed " + std::to_string(device.hand.seed) + ", closed loop";
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
  if (row_of(config.device.kind).is_recorded)
    add_coverage_rows(data, hand, config.servo_rate, rows);
  rows.note("log", options.log);
  if (!options.plot.empty()) rows.note("plot", options.plot);
  return rows.rows();
}

/// A hand that touches nothing is the usual sign of an object that is too far away or too small.
void tell_untouched(const PlayOptions& options, const SessionData& data) {
  if (std::any_of(data.frames.begin(), data.frames.end(),
                  [](const ServoFrame& f) { return (f.flags & kServoContact) != 0; })) {
    return;
  }
  std::cerr << one_line(
                   "hapt: the hand touched nothing: every object is out of its reach; check "
                   "'position', 'size' and 'unit' of the objects in " +
                   options.config)
            << '\n';
}

void play(PlayOptions options) {
  catch_stop_signals();
  options.config = find_config(options.config);
  SessionConfig config = load_config(options.config);
  if (!options.trace.empty()) use_trace(config, options.trace);
  if (!options.renderer.empty()) use_renderer(config, options.renderer);
  if (options.session.empty()) options.session = std::string(view(config.name));
  if (options.log.empty()) options.log = default_log(options.session);
  const bool replay = row_of(config.device.kind).is_recorded;
  check_outputs({options.log, options.plot},
                {options.config, replay ? std::string(view(config.device.replay.path)) : ""},
                options.overwrite);
  Recording hand{0, options.duration};
  if (replay) {
    const HandTrace trace = load_hand_trace(config.device.replay);
    hand = {trace.samples.size(), trace.duration()};
    if (!trace.notice.empty()) {
      std::cerr << shown(view(config.device.replay.path)) << ": " << trace.notice << '\n';
    }
  }

  // baked here once: contact then finds it in the cache, and the evaluation needs it too
  const BakedSession baked = bake_all(config);
  const Played played = play_and_record(options, replay, hand.seconds);
  SessionData data = load_session(options.log);
  data.lost = played.lost;
  const std::vector<Row> rows = judge(options, config, baked, hand, played, data);
  if (options.json) {
    print_json(std::cout, rows);
  } else {
    std::cout << "session '" << shown(options.session) << "'\n";
    print_table(std::cout, rows);
  }
  std::cout.flush();
  if (played.ended_early) {
    std::cerr << "the session ended early; what was recorded is in " << shown(options.log) << '\n';
  }
  if (!options.plot.empty()) plot_session(options.plot, "session " + options.session, data);
  const bool passed = !played.ended_early && all_hold(rows);
  if (!played.ended_early) tell_untouched(options, data);
  if (!options.json) {
    std::cout << (passed ? "passed: every goal is met\n" : "FAILED: see the goals above\n");
  }
  if (!passed) throw ExitCode{kExitFailed};
}

void add_common(Command& command, PlayOptions& options) {
  add_config(command, options.config).show_default();
  command
      .option("--renderer", options.renderer, "instead of the session file's: " + renderer_names())
      .show_default("the session file's");
  command.option("--session", options.session, "name to run under")
      .show_default("the session file's");
  command.option("-o,--output FILE.mcap", options.log, "recording to write")
      .show_default("the session's name and the time");
  add_plot(command, options.plot);
  add_overwrite(command, options.overwrite);
  add_json(command, options.json);
}

}  // namespace

void add_demo_command(Command& app) {
  const auto options = std::make_shared<PlayOptions>();
  Command command =
      app.subcommand("demo", "Run a simulated hand on a mesh, record it and print a report");
  add_common(command, *options);
  const auto scene = std::make_shared<std::string>();
  command
      .option("SCENE", *scene,
              "bunny: a point on a mesh; peg, gears, teeth, bunnies: bodies that push and turn; "
              "rigid-peg, rigid-bunnies: bodies that never enter another")
      .one_of(scene_names())
      .excludes("--config")
      .show_default("bunny");
  command.option("--trace FILE", options->trace,
                 "recorded hand (.mcap or .csv) instead of the simulated one");
  add_duration(command, "--for", options->duration, "how long the hand explores").show_default();
  command.example("hapt demo peg --for 10s -o peg.mcap");
  command.action([options, scene, command] {
    if (scene->empty() && !command.was_given("--config")) *scene = default_scene();
    if (!scene->empty()) options->config = prepare_scene(*scene);
    play(*options);
  });
}

void add_replay_command(Command& app) {
  const auto options = std::make_shared<PlayOptions>();
  Command command = app.subcommand("replay", "Play a recorded hand (open loop) through a session");
  command.option("TRACE", options->trace, "recorded hand: .mcap or .csv").required();
  add_common(command, *options);
  command.example("hapt replay hand.csv --config plane.toml");
  command.action([options] { play(*options); });
}

}  // namespace haptic
