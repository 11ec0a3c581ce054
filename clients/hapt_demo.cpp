// SPDX-License-Identifier: GPL-3.0-or-later
// hapt demo and hapt replay: start a session, record it, judge it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <memory>

#include "clients/find_config.h"
#include "clients/hapt_commands.h"
#include "clients/realtime_line.h"
#include "clients/recorder.h"
#include "clients/session_plot.h"
#include "clients/session_process.h"
#include "clients/summary.h"
#include "proto/hand_trace.h"
#include "proto/process.h"
#include "proto/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kDrainPeriod = 10'000'000;           // [ns]
constexpr int64_t kProgressPeriod = kNsPerSecond / 4;  // [ns]
constexpr int64_t kStartPatience = 60 * kNsPerSecond;  // a mesh may have to be baked first
constexpr double kNoNewsLimit = 10;                    // a session that shows nothing is broken [s]

struct PlayOptions {
  std::string config = "bunny.toml", session, trace, log, plot;
  double duration = 20;
  bool json = false;
};

/// What the recorder saw go by while the session ran.
struct Played {
  std::string realtime;
  uint64_t lost = 0;
  bool interrupted = false;
};

std::string default_log(const std::string& session) {
  char stamp[32];
  const std::time_t now = std::time(nullptr);
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  return session + "-" + stamp + ".mcap";
}

std::vector<BakedShape> bake_all(const SessionConfig& config) {
  std::vector<BakedShape> baked;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    std::cerr << "reading and checking " << view(config.objects[i].mesh) << '\n';
    baked.push_back(bake_object(config.objects[i], config.mesh_memory_limit));
    for (const std::string& line : baked.back().report.lines) std::cerr << "  " << line << '\n';
  }
  return baked;
}

/// A line that overwrites itself on a terminal and is silent elsewhere.
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

FileDescriptor connect_when_ready(SessionProcess& daemon, const std::string& session) {
  for (const int64_t start = now_ns();;) {
    if (const auto code = daemon.exit_code()) {
      throw std::runtime_error("hapticd ended with code " + std::to_string(*code) +
                               " before the session was up; its message is above");
    }
    try {
      return connect_session(session);
    } catch (const HandoutError&) {
      if (now_ns() - start > kStartPatience) throw;
    }
    sleep_until(now_ns() + kDrainPeriod);
  }
}

/// Records until the hand has played, then stops the session and drains what is left.
Played play_and_record(const PlayOptions& options, const SessionConfig& config, double seconds,
                       TraceWriter& trace) {
  std::vector<std::string> arguments{options.config, "--session", options.session};
  if (!options.trace.empty()) arguments.insert(arguments.end(), {"--replay", options.trace});
  SessionProcess daemon(arguments);
  Attachments attachments(connect_when_ready(daemon, options.session));
  Recorder recorder(attachments, Start::kOldest);
  auto watched = attachments.ring<&ServoChannels::frames>(Start::kOldest);
  attachments.start();

  Played played;
  Progress progress(seconds);
  ServoFrame frame{};
  double shown = 0;
  int64_t first_ns = 0, news_ns = now_ns();
  const bool replay = config.device.kind == DeviceKind::kReplay;
  for (bool done = false; !done;) {
    sleep_until(now_ns() + kDrainPeriod);
    if (!recorder.drain(trace, now_ns())) break;
    if (watched.latest(frame)) {
      if (first_ns == 0) first_ns = frame.t_ns;
      news_ns = now_ns();
      shown = static_cast<double>(frame.t_ns - first_ns) * 1e-9;
      progress.show(frame, shown, news_ns);
    }
    const bool ended = (frame.device.flags & kDeviceEnded) != 0;
    done = ended || (!replay && shown >= seconds);
    played.interrupted = stop_requested() || daemon.exit_code().has_value() ||
                         static_cast<double>(now_ns() - news_ns) * 1e-9 > kNoNewsLimit;
    done |= played.interrupted;
  }
  daemon.stop();
  recorder.finish(trace, now_ns());
  for (const TopicCount& count : recorder.counts()) played.lost += count.lost;
  played.realtime = realtime_line(recorder.servo_header());
  if (!trace.error().empty()) throw std::runtime_error(trace.error());
  return played;
}

/// Every sample of the recorded hand was either used for a frame or counted as skipped.
void add_coverage_rows(const std::string& name, const SessionData& data, size_t samples,
                       std::vector<Row>& rows) {
  const auto is_ended = [](const ServoFrame& f) { return (f.device.flags & kDeviceEnded) != 0; };
  const auto end = std::find_if(data.frames.begin(), data.frames.end(), is_ended);
  const auto used = static_cast<double>(end - data.frames.begin());
  if (data.frames.empty()) return;
  const ServoFrame& last = end == data.frames.end() ? data.frames.back() : *end;
  // grid points skipped over the end of the recording cost no sample
  const auto covered = static_cast<double>(last.tick - data.frames.front().tick);
  const double beyond = std::max(0.0, covered - static_cast<double>(samples));
  const double skipped = static_cast<double>(last.skipped - data.frames.front().skipped) - beyond;
  const double total = used + skipped;
  rows.push_back(
      {name, "samples of the recorded hand", static_cast<double>(samples), "", "", {}, {}, {}});
  rows.push_back({name,
                  "frames plus counted skips",
                  total,
                  "",
                  "",
                  {},
                  static_cast<double>(samples),
                  total == static_cast<double>(samples)});
}

void print_people(const PlayOptions& options, const SessionConfig& config, const Played& played,
                  const std::vector<Row>& rows) {
  const MachineInfo machine = machine_info();
  const bool simulated = config.device.kind == DeviceKind::kSimulatedHand;
  std::cout << "session '" << view(config.name) << "': "
            << (simulated ? "SIMULATED hand, seed " + std::to_string(config.device.hand.seed) +
                                ", closed loop"
                          : "RECORDED hand " + options.trace + ", open loop: force has no effect")
            << '\n'
            << "hapticd " << machine.version << " on " << machine.cpu << ", " << machine.cores
            << " cores, kernel " << machine.kernel << ", load " << machine.load << '\n';
  print_table(std::cout, rows);
  std::cout << played.realtime << '\n' << "log: " << options.log << '\n';
  if (!options.plot.empty()) std::cout << "plot: " << options.plot << '\n';
}

void play(PlayOptions options) {
  catch_stop_signals();
  options.config = find_config(options.config);
  SessionConfig config = load_config(options.config);
  if (!options.trace.empty()) use_trace(config, options.trace);
  if (options.session.empty()) options.session = std::string(view(config.name));
  if (options.log.empty()) options.log = default_log(options.session);
  size_t samples = 0;
  double seconds = options.duration;
  if (config.device.kind == DeviceKind::kReplay) {
    const HandTrace hand = load_hand_trace(config.device.replay);
    samples = hand.samples.size();
    seconds = hand.duration();
  }

  // baked here once, so that contact finds it in the cache and the judge has it too
  const std::vector<BakedShape> baked = bake_all(config);
  TraceWriter trace(options.log,
                    recording_metadata(options.session, read_config_text(options.config), ""));
  const Played played = play_and_record(options, config, seconds, trace);
  SessionData data = load_session(options.log);
  data.lost = played.lost;
  std::vector<Row> rows =
      summarize(options.session, data, config, measure_penetration(data, config, baked));
  if (samples > 0) add_coverage_rows(options.session, data, samples, rows);

  if (!options.plot.empty()) plot_session(options.plot, "session " + options.session, data);
  if (options.json) {
    print_json(std::cout, rows);
    std::cerr << played.realtime << '\n' << "log: " << options.log << '\n';
  } else {
    print_people(options, config, played, rows);
  }
  if (played.interrupted) {
    std::cerr << "the session ended early; what was recorded is in " << options.log << '\n';
  }
  if (played.interrupted || !all_hold(rows)) throw CLI::RuntimeError(1);
}

void add_common(CLI::App& command, PlayOptions& options) {
  command.add_option("--config", options.config, "session file")->capture_default_str();
  command.add_option("--session", options.session, "name to run under; default: the file's");
  command.add_option("-o,--output", options.log, "log to write (.mcap)");
  command.add_option("--plot", options.plot, "draw force, depth and lateness to this .svg");
  command.add_flag("--json", options.json, "figures as JSON on standard output");
}

}  // namespace

void add_demo_command(CLI::App& app) {
  const auto options = std::make_shared<PlayOptions>();
  CLI::App* command =
      app.add_subcommand("demo", "A simulated hand explores a mesh; recorded and judged");
  add_common(*command, *options);
  command->add_option("--trace", options->trace, "a recorded hand instead of the simulated one");
  command->add_option("--for", options->duration, "how long the hand explores [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->callback([options] { play(*options); });
}

void add_replay_command(CLI::App& app) {
  const auto options = std::make_shared<PlayOptions>();
  CLI::App* command =
      app.add_subcommand("replay", "Play a recorded hand (open loop) through a session");
  command->add_option("trace", options->trace, "recording: .mcap or .csv")->required();
  add_common(*command, *options);
  command->callback([options] { play(*options); });
}

}  // namespace haptic
