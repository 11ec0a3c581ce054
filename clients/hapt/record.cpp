// SPDX-License-Identifier: GPL-3.0-or-later
// hapt record: records everything that a running session publishes.
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/hapt/session_choice.h"
#include "clients/library/client.h"
#include "clients/library/recorder.h"
#include "clients/log/trace_writer.h"
#include "proto/config/command_line.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr int64_t kDrainPeriodNs = 10'000'000;  // a hundredth of what the smallest ring holds

struct RecordOptions {
  std::string output, config;
  SessionChoice session;
  double duration = std::numeric_limits<double>::infinity();  // [s]
  double standard_rate = kStandardRate;
  bool json = false, overwrite = false;
};

/// Size of the closed file, index and all [bytes]; 0: it is not there.
uint64_t size_on_disk(const std::string& path) {
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(path, unknown);
  return unknown ? 0 : bytes;
}

void print_json(const Recorder& recorder, uint64_t bytes, double seconds) {
  Json rows = Json::array();
  for (const TopicCount& count : recorder.counts()) {
    rows.push_back({{"topic", count.topic},
                    {"recorded", count.recorded},
                    {"lost", count.lost},
                    {"seconds", seconds},
                    {"file_bytes", bytes}});
  }
  std::cout << json_lines(rows);
}

void print_table(const Recorder& recorder, uint64_t bytes, const std::string& path,
                 double seconds) {
  for (const TopicCount& count : recorder.counts()) {
    std::cout << "  " << count.topic << ": " << count.recorded << " recorded, " << count.lost
              << " lost\n";
  }
  uint64_t lost = 0;
  for (const TopicCount& count : recorder.counts()) lost += count.lost;
  std::cout << "recorded: " << formatted("%.1f s, ", seconds) << (bytes >> 10) << " KiB in "
            << shown(path) << ", "
            << (lost == 0 ? "nothing lost" : std::to_string(lost) + " records LOST")
            << "; next: hapt info " << shown(path) << '\n';
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

/// The pose X_WB of the device's base; none if the session file is unknown or cannot be read.
std::optional<Pose> base_of(const std::string& config) {
  try {
    if (!config.empty()) return parse_config(config, "session.toml").map.X_WB;
  } catch (const ConfigError&) {
    // the recording is worth as much without it
  }
  return std::nullopt;
}

/// Gives the thread that drains the rings and the one that writes the file real-time priority,
/// where the session has it and the kernel grants it. Returns whether the servo has been seen.
bool follow_realtime(Recorder& recorder, TraceWriter& trace) {
  const SegmentHeader* servo = recorder.servo_header();
  if (servo == nullptr) return false;
  const bool is_realtime = (servo->realtime_bits.load() & kRealtimeFifo) != 0;
  if (is_realtime) enter_realtime({.fifo_priority = kRecorderPriority, .lock_memory = false});
  trace.share_priority();
  return true;
}

/// A recording under way. hapticd may be killed and come back: the file goes on with the frames of
/// the new session.
class RunningRecording {
 public:
  RunningRecording(const RecordOptions& options, FileDescriptor socket, const std::string& session,
                   const std::string& config)
      : options_(options),
        session_(session),
        config_(config),
        eyes_(std::make_unique<EyeBook>()),
        attachments_(std::make_unique<Attachments>(std::move(socket), eyes_->options())),
        recorder_(*attachments_, Start::kNewest, options.standard_rate),
        trace_(options.output, recording_metadata(session, config)) {
    recorder_.follow(*eyes_);
    if (const auto X_WB = base_of(config)) recorder_.set_base(*X_WB);
    attachments_->start();
    if (std::isfinite(options.duration)) progress_.emplace("recording", options.duration);
  }

  void run() {
    do {
      drain();
    } while (good_ && !is_over() && come_back());
    progress_.reset();
    good_ = recorder_.finish(trace_, now_ns());
    const uint64_t bytes = size_on_disk(options_.output);
    if (options_.json) {
      print_json(recorder_, bytes, seconds());
    } else {
      print_table(recorder_, bytes, options_.output, seconds());
    }
    if (!good_) throw MessageError(recorder_.failure());
    if (!refusal().empty()) throw HandoutError(refusal());
  }

 private:
  double seconds() const { return static_cast<double>(now_ns() - begin_ns_) * 1e-9; }
  bool is_over() const { return seconds() >= options_.duration || stop_requested(); }
  std::string refusal() const {
    return attachments_->is_connected() ? "" : attachments_->refusal();
  }

  /// Records until the end, or until hapticd is gone.
  void drain() {
    while (good_ && !is_over() && attachments_->is_connected()) {
      sleep_until(now_ns() + kDrainPeriodNs);
      good_ = recorder_.drain(trace_, now_ns());
      followed_ = followed_ || follow_realtime(recorder_, trace_);
      if (progress_) progress_->at(seconds());
    }
  }

  /// Waits for the next hapticd; false: there will be none, or not in time.
  bool come_back() {
    if (!refusal().empty()) return false;
    good_ = recorder_.drain(trace_, now_ns());  // what the dead one has left
    if (recorder_.has_ended()) {
      std::cerr << "the session has ended\n";
      return false;
    }
    if (!good_) return false;
    std::cerr << "hapticd is gone; the recording goes on when it is back, Ctrl-C ends it\n";
    trace_.close_chunk();
    const int64_t gone_ns = now_ns();
    FileDescriptor socket = connect_again(session_, [this] { return is_over(); });
    if (!socket.is_open()) return false;
    // another hapticd counts its generations anew
    auto eyes = std::make_unique<EyeBook>();
    auto next = std::make_unique<Attachments>(std::move(socket), eyes->options());
    recorder_.go_on(*next, trace_);
    recorder_.follow(*eyes);
    attachments_ = std::move(next);
    eyes_ = std::move(eyes);
    attachments_->start();
    const double missed = static_cast<double>(now_ns() - gone_ns) * 1e-9;
    std::cerr << formatted("hapticd is back after %.2f s; the recording goes on\n", missed);
    keep_other_config();
    return true;
  }

  /// The session file of the new session, where it is another.
  void keep_other_config() {
    if (!options_.config.empty()) return;
    const std::string config = config_of(session_);
    if (config.empty() || config == config_) return;
    config_ = config;
    std::cerr << "its session file is another; the recording holds both\n";
    trace_.add_metadata("recording " + std::to_string(++n_configs_), {{"config", config}});
  }

  const RecordOptions& options_;
  std::string session_, config_;
  int n_configs_ = 1;
  std::unique_ptr<EyeBook> eyes_;  // outlives the thread that fills it
  std::unique_ptr<Attachments> attachments_;
  Recorder recorder_;
  TraceWriter trace_;
  std::optional<Progress> progress_;
  const int64_t begin_ns_ = now_ns();
  bool good_ = true, followed_ = false;
};

void run_record(const RecordOptions& options) {
  check_outputs({options.output}, {options.config}, options.overwrite);
  std::string config =
      options.config.empty() ? "" : read_config_text(find_session_file(options.config));
  FileDescriptor socket = connect_session(once_up(options.session));
  const std::string session = peer_of(socket).session;
  if (options.config.empty()) config = config_of(session);
  catch_stop_signals();
  RunningRecording recording(options, std::move(socket), session, config);
  std::cerr << "recording to " << shown(options.output) << "; Ctrl-C ends it\n";
  recording.run();
}

}  // namespace

void add_record_command(Command& app) {
  add_command<RecordOptions>(
      app, "record", "Record a running session", run_record,
      [](Command& command, RecordOptions& options) {
        command.option("-o,--output FILE.mcap", options.output, "file to write").required();
        add_duration(command, "--for", options.duration, "how long").show_default("until Ctrl-C");
        add_session(command, options.session);
        command.option("--config FILE", options.config, "session file to keep in the recording")
            .show_default("what hapticd has read");
        add_standard_rate(command, options.standard_rate);
        add_overwrite(command, options.overwrite);
        add_json(command, options.json);
        command.example("hapt record -o out.mcap --for 10s");
      });
}

}  // namespace haptic
