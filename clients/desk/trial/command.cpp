// SPDX-License-Identifier: GPL-3.0-or-later
// hapt devices try: a device's first moments, in three steps that are asked for one by one, and a
// report of them.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <memory>
#include <optional>

#include "clients/desk/trial/asking.h"
#include "clients/desk/trial/byte_record.h"
#include "clients/desk/trial/command.h"
#include "clients/desk/trial/serial_tap.h"
#include "clients/desk/trial/trial_report.h"
#include "clients/desk/trial/trial_run.h"
#include "clients/hapt/check_outputs.h"
#include "clients/hapt/options.h"
#include "device-io/plugged/find_node.h"
#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/serial_port.h"
#include "proto/os/session_file.h"
#include "proto/os/text.h"
#include "servo/model.h"

namespace haptic {
namespace {

constexpr int64_t kShowNs =
    100'000'000;  // [ns], between two lines at a terminal: ten a second can be read

struct TryOptions : TriedDevice {
  std::string output;
  bool overwrite = false;
};

/// A line that follows the handle, where there is a terminal.
class LiveLine {
 public:
  ~LiveLine() {
    if (at_terminal_) std::fputs("\r\x1b[K", stdout);
  }
  void show(const DeviceState& device) {
    if (!at_terminal_ || device.t_ns - shown_ns_ < kShowNs) return;
    shown_ns_ = device.t_ns;
    const Vec3 &p = device.X_BH.p, &v = device.V_BH.v;
    std::printf("\r  x %7.1f  y %7.1f  z %7.1f mm   %5.2f m/s  buttons %x  %s\x1b[K", 1e3 * p.x,
                1e3 * p.y, 1e3 * p.z, norm(v), device.buttons, state_of(device));
    std::fflush(stdout);
  }

 private:
  static const char* state_of(const DeviceState& device) {
    if ((device.flags & kDeviceLost) != 0) return "LOST";
    if ((device.flags & kDeviceStale) != 0) return "STALE";
    return (device.flags & kDeviceHomed) != 0 ? "homed" : "not homed";
  }

  bool at_terminal_ = isatty(STDOUT_FILENO) == 1;
  int64_t shown_ns_ = 0;
};

/// Prints the rows of a step; true if nothing failed.
bool show_rows(const std::vector<TrialRow>& rows) {
  for (const TrialRow& row : rows) std::cout << words_of(row) << '\n';
  std::cout << std::flush;
  return std::ranges::none_of(rows,
                              [](const TrialRow& row) { return row.verdict == Verdict::kFailed; });
}

/// The steps one after the other, until one fails or is not wanted.
void try_device(Device& device, const SafetyLimits& limits, double rate, const TryOptions& options,
                std::vector<TriedStep>& steps) {
  TrialRun run(device, limits, rate);
  LiveLine line;
  const auto does = [&](const char* name, const auto& rows_of) {
    steps.push_back({name, {}, "stopped"});  // whatever ends it before
    steps.back().rows = rows_of();
    steps.back().ended = {};
    return show_rows(steps.back().rows);
  };
  const auto is_wanted = [&](const char* name, const std::string& question) {
    steps.push_back({name, {}, "stopped at its question"});
    const bool agreed = is_agreed(&run, options.yes, question);
    steps.back().ended = "not wanted";
    if (agreed) steps.pop_back();
    return agreed;
  };
  std::cout << "step 1 of 3: 5 s without force. Move the handle about, in every direction.\n"
            << std::flush;
  if (!does("1 of 3, without force",
            [&] { return run.look([&](const DeviceState& state) { line.show(state); }); })) {
    return;
  }
  if (limits.max_force <= 0) {
    std::cout << "it has no motors: that was all\n";
    return;
  }
  constexpr const char* kSecond = "2 of 3, 5 % of the force";
  if (!is_wanted(kSecond,
                 "step 2 of 3: 5 % of the force, along each axis to and fro. Hold the handle "
                 "loosely, in the middle of its range, a hand on the plug. Go on?") ||
      !does(kSecond, [&] { return run.push(); })) {
    return;
  }
  const auto newtons = std::to_string(limits.max_force).substr(0, 4);
  const std::string third = "3 of 3, the force along x up to " + newtons + " N";
  if (is_wanted(third.c_str(), "step 3 of 3: the force along x rises to " + newtons +
                                   " N in 3 s. Hold the handle firmly. Go on?")) {
    does(third.c_str(), [&] { return run.full(); });
  }
}

/// A device that is recorded while it is tried: a serial line at its node, others by their drivers.
class RecordedDevice {
 public:
  explicit RecordedDevice(const DeviceConfig& config) {
    FileDescriptor node = open_node(config);
    if (row_of(config.kind).node == NodeKind::kSerial) {
      tap_ = std::make_unique<SerialTap>(std::move(node));
      node = tap_->driver_end();
    }
    device_ = open_device(config, std::move(node));
    if (tap_) return;
    record_ = std::make_unique<ByteRecord>();
    is_heard_ = record_->listen_to(*device_);
  }

  Device& device() { return *device_; }

  /// Ends the device and writes the report, with all that was said.
  void save(TrialReport& report, const std::string& path) {
    device_.reset();
    const std::vector<DeviceBytes>& pieces = tap_ ? tap_->finish() : record_->pieces();
    const bool cut = tap_ ? tap_->is_cut() : record_->is_cut();
    report.bytes = std::to_string(pieces.size()) + " pieces" + (cut ? ", without the end" : "");
    if (!is_heard_) report.bytes = "none, for its driver does not tell them";
    save_whole(path,
               [&](std::ostream& out) { write_device_bytes(pieces, out, remarks_of(report)); });
    std::cout << "\nreport: " << shown(path)
              << " has all of this and its bytes; please send it in, "
              << "nothing is sent by itself\n";
  }

 private:
  std::unique_ptr<SerialTap> tap_;
  std::unique_ptr<ByteRecord> record_;
  bool is_heard_ = true;
  std::unique_ptr<Device> device_;  // last: what listens to it outlives it
};

/// "hapt-try-falcon-20261127-143012.txt", in the folder where it is typed.
std::string report_name(const std::string& kind) {
  const std::time_t now = std::time(nullptr);
  char when[32];
  std::strftime(when, sizeof when, "%Y%m%d-%H%M%S", std::localtime(&now));
  return "hapt-try-" + kind + "-" + when + ".txt";
}

/// The steps on the device of a config, and the report of them.
void try_recorded(const SessionConfig& config, const TryOptions& options, TrialReport report,
                  const std::string& path) {
  RecordedDevice tried(config.device);
  const DeviceCaps caps = tried.device().caps();
  if (caps.causality == Causality::kAdmittance) {
    throw InputError("a device that is commanded a pose cannot be tried this way");
  }
  const SafetyLimits limits =
      build_servo_model(config, {caps.max_force, caps.max_torque, false}).limits;
  report.description = tried.device().description();
  report.facts.push_back(formatted("limits: %.3g N, %.3g N*m, %.4g Hz", limits.max_force,
                                   limits.max_torque, config.servo_rate));
  std::cout << one_line(report.description) << '\n';
  enter_realtime({.fifo_priority = config.realtime != 0 ? kServoPriority : 0});
  std::optional<ExitCode> stopped;
  try {
    try_device(tried.device(), limits, config.servo_rate, options, report.steps);
  } catch (const ExitCode& code) {
    stopped = code;
  }
  // a trial until Ctrl-C is worth as much
  tried.save(report, path);
  if (stopped) throw *stopped;
  for (const TriedStep& step : report.steps) {
    for (const TrialRow& row : step.rows) {
      if (row.verdict != Verdict::kPassed) throw ExitCode{kExitFailed};
    }
  }
}

void try_out(const TryOptions& options, const ReportFacts& facts) {
  check_terminal(options.yes);
  const SessionConfig config = config_of(options);
  const std::string kind(row_of(config.device.kind).name);
  const std::string path = options.output.empty() ? report_name(kind) : options.output;
  check_outputs({path}, {}, options.overwrite);
  if (!is_agreed(nullptr, options.yes,
                 "This opens the " + kind + " and reads it, without force. Begin?")) {
    return;
  }
  catch_stop_signals();
  // before it is opened: the lock of the node is then another's
  try_recorded(config, options, {.kind = kind, .facts = facts(find_node(config.device))}, path);
}

}  // namespace

void add_try_command(Command& devices, bool& ran, const ReportFacts& facts) {
  const auto options = std::make_shared<TryOptions>();
  Command command = devices.subcommand(
      "try", "Try a new device in three guarded steps, from reading it to all of its force");
  add_tried_device(command, *options, "KIND|CONFIG",
                   "kind of the device, or a session file with it");
  command.option("-o,--output FILE", options->output,
                 "name of the report, which has each step and the bytes of both sides");
  add_overwrite(command, options->overwrite);
  command.example("hapt devices try woodenhaptics --path /dev/ttyACM0 -o woody.txt");
  command.action([options, &ran, facts] {
    ran = true;
    try_out(*options, facts);
  });
}

}  // namespace haptic
