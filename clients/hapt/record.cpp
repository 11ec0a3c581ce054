// SPDX-License-Identifier: GPL-3.0-or-later
// hapt record: records everything that a running session publishes.
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/find_config.h"
#include "clients/hapt/options.h"
#include "clients/library/recorder.h"
#include "clients/report/progress.h"
#include "proto/config/command_line.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kDrainPeriodNs = 10'000'000;  // a hundredth of what the smallest ring holds
// under every process of a session, above whoever watches: a ring holds four seconds, which is less
// than sixty busy viewers may take from a recorder of normal priority
constexpr int kFifoPriority = 10;

struct RecordOptions {
  std::string output, session, config;
  double duration = std::numeric_limits<double>::infinity();  // [s]
  double standard_rate = kStandardRate;
  bool json = false, overwrite = false;
};

void print_json(const Recorder& recorder, const TraceWriter& trace, double seconds) {
  std::cout << "[";
  const char* separator = "\n";
  for (const TopicCount& count : recorder.counts()) {
    std::cout << separator << "  {\"topic\": \"" << count.topic
              << "\", \"recorded\": " << count.recorded << ", \"lost\": " << count.lost
              << ", \"seconds\": " << seconds << ", \"file_bytes\": " << trace.size() << "}";
    separator = ",\n";
  }
  std::cout << "\n]\n";
}

void print_table(const Recorder& recorder, const TraceWriter& trace, const std::string& path,
                 double seconds) {
  for (const TopicCount& count : recorder.counts()) {
    std::cout << "  " << count.topic << ": " << count.recorded << " recorded, " << count.lost
              << " lost\n";
  }
  std::cout << shown(path) << ": " << seconds << " s, " << (trace.size() >> 10) << " KiB\n";
}

/// The session file as hapticd has read it. A client that may watch but not control is refused, and
/// the recording then lacks it.
std::string config_of(const std::string& session) {
  std::string problem;
  try {
    std::string answer = say_to_session(session, "config");
    const std::optional<std::string> refusal = refusal_in(answer);
    if (!refusal) return answer;
    problem = *refusal;
  } catch (const HandoutError& error) {
    problem = error.what();
  }
  std::cerr << "the recording will not hold the session file: " << problem
            << "; name it with --config\n";
  return "";
}

/// Where the base of the device is; none where the session file is not known, or not read here.
std::optional<Pose> base_of(const std::string& config) {
  try {
    if (!config.empty()) return parse_config(config, "session.toml").map.X_WB;
  } catch (const ConfigError&) {
    // the recording is worth as much without it
  }
  return std::nullopt;
}

/// Real time like the session that is recorded, where it is and the kernel grants it. Returns
/// whether the servo has been seen.
bool follow_realtime(Recorder& recorder) {
  const SegmentHeader* servo = recorder.servo_header();
  if (servo == nullptr) return false;
  const bool is_realtime = (servo->realtime_bits.load() & kRealtimeFifo) != 0;
  if (is_realtime) enter_realtime({.fifo_priority = kFifoPriority, .lock_memory = false});
  return true;
}

void run_record(const RecordOptions& options) {
  check_outputs({options.output}, {options.config}, options.overwrite);
  std::string config = options.config.empty() ? "" : read_config_text(find_config(options.config));
  FileDescriptor socket = connect_session(options.session);
  const std::string session = peer_of(socket).session;
  if (options.config.empty()) config = config_of(session);
  EyeBook eyes;
  Attachments attachments(std::move(socket), eyes.options());
  Recorder recorder(attachments, Start::kNewest, options.standard_rate);
  recorder.follow(eyes);
  if (const auto X_WB = base_of(config)) recorder.set_base(*X_WB);
  attachments.start();
  catch_stop_signals();

  TraceWriter trace(options.output, recording_metadata(session, config));
  std::cerr << "recording to " << shown(options.output) << "; Ctrl-C ends it\n";
  const int64_t begin_ns = now_ns();
  double seconds = 0;
  bool good = true, followed = false;
  std::optional<Progress> progress;
  if (std::isfinite(options.duration)) progress.emplace("recording", options.duration);
  while (good && seconds < options.duration && !stop_requested() && attachments.is_connected()) {
    sleep_until(now_ns() + kDrainPeriodNs);
    good = recorder.drain(trace, now_ns());
    followed = followed || follow_realtime(recorder);
    seconds = static_cast<double>(now_ns() - begin_ns) * 1e-9;
    if (progress) progress->at(seconds);
  }
  progress.reset();
  const bool connected = attachments.is_connected();
  if (!connected && attachments.refusal().empty()) std::cerr << "the session has ended\n";
  good = recorder.finish(trace, now_ns());
  if (options.json) {
    print_json(recorder, trace, seconds);
  } else {
    print_table(recorder, trace, options.output, seconds);
  }
  if (!good) throw MessageError(recorder.failure());
  if (!connected && !attachments.refusal().empty()) throw HandoutError(attachments.refusal());
}

}  // namespace

void add_record_command(Command& app) {
  const auto options = std::make_shared<RecordOptions>();
  Command command = app.subcommand("record", "Record a running session");
  command.option("-o,--output FILE.mcap", options->output, "file to write").required();
  add_duration(command, "--for", options->duration, "how long").show_default("until Ctrl-C");
  add_session(command, options->session);
  command.option("--config FILE", options->config, "session file to keep in the recording")
      .show_default("what hapticd has read");
  add_standard_rate(command, options->standard_rate);
  add_overwrite(command, options->overwrite);
  add_json(command, options->json);
  command.example("hapt record -o out.mcap --for 10s");
  command.action([options] { run_record(*options); });
}

}  // namespace haptic
