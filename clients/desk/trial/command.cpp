// SPDX-License-Identifier: GPL-3.0-or-later
// hapt devices try: a device's first moments, in three steps that are asked for one by one.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>

#include "clients/desk/trial/byte_record.h"
#include "clients/desk/trial/command.h"
#include "clients/desk/trial/serial_tap.h"
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

struct TryOptions {
  std::string what, path, output;
  bool yes = false, overwrite = false;
};

SessionConfig config_of(const TryOptions& options) {
  const auto row = std::ranges::find(kDevices, options.what, &DeviceRow::name);
  SessionConfig config{};
  if (row != kDevices.end()) {
    config.device.kind = row->id;
  } else {
    config = load_config(find_session_file(options.what));
  }
  const DeviceRow& device = row_of(config.device.kind);
  if (!device.has_node()) {
    throw InputError(std::string(device.name) + " is no hardware; nothing is to be tried");
  }
  if (!options.path.empty()) assign(config.device.serial.path, options.path);
  if (device.node == NodeKind::kSerial && view(config.device.serial.path).empty()) {
    throw InputError("give the serial port of the " + std::string(device.name) +
                     " with --path (`hapt devices` lists those that are there)");
  }
  return config;
}

/// Asks at the terminal while the device is kept without force.
bool is_agreed(TrialRun* run, const TryOptions& options, const std::string& question) {
  std::cout << '\n' << question << std::flush;
  if (options.yes) {
    std::cout << " yes (--yes)\n";
    return true;
  }
  std::cout << " [y/N] " << std::flush;
  const auto has_answer = [] {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    return poll(&in, 1, 0) > 0;
  };
  if (run != nullptr) run->wait_for(has_answer);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y" || answer == "yes";
}

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

constexpr std::array kVerdictWords{"passed", "unclear", "FAILED"};  // by Verdict

/// Prints the rows of a step; true if nothing failed.
bool report(const std::vector<TrialRow>& rows, std::vector<TrialRow>& all) {
  bool good = true;
  for (const TrialRow& row : rows) {
    const char* word = kVerdictWords[static_cast<size_t>(row.verdict)];
    std::cout << "  " << padded(word, 9) << row.what << ": " << row.measured << '\n';
    good &= row.verdict != Verdict::kFailed;
    all.push_back(row);
  }
  std::cout << std::flush;
  return good;
}

/// The steps one after the other, until one fails or is not wanted.
std::vector<TrialRow> try_device(Device& device, const SafetyLimits& limits, double rate,
                                 const TryOptions& options) {
  std::vector<TrialRow> all;
  TrialRun run(device, limits, rate);
  LiveLine line;
  std::cout << "step 1 of 3: 5 s without force. Move the handle about, in every direction.\n"
            << std::flush;
  const bool answers = report(run.look([&](const DeviceState& state) { line.show(state); }), all);
  if (!answers) return all;
  if (limits.max_force <= 0) {
    std::cout << "it has no motors: that was all\n";
    return all;
  }
  if (!is_agreed(&run, options,
                 "step 2 of 3: 5 % of the force, along each axis to and fro. Hold the handle "
                 "loosely, in the middle of its range, a hand on the plug. Go on?") ||
      !report(run.push(), all)) {
    return all;
  }
  const auto newtons = std::to_string(limits.max_force).substr(0, 4);
  if (is_agreed(&run, options,
                "step 3 of 3: the force along x rises to " + newtons +
                    " N in 3 s. Hold the handle firmly. Go on?")) {
    report(run.full(), all);
  }
  return all;
}

/// A device that may be recorded while it is tried: a serial line at its node, others by their
/// drivers.
class RecordedDevice {
 public:
  RecordedDevice(const DeviceConfig& config, bool is_recorded) {
    FileDescriptor node = open_node(config);
    if (is_recorded && row_of(config.kind).node == NodeKind::kSerial) {
      tap_ = std::make_unique<SerialTap>(std::move(node));
      node = tap_->driver_end();
    }
    device_ = open_device(config, std::move(node));
    if (!is_recorded || tap_) return;
    record_ = std::make_unique<ByteRecord>();
    if (!record_->listen_to(*device_)) throw std::logic_error("its driver does not tell its bytes");
  }

  Device& device() { return *device_; }

  /// Ends the device and writes what was said.
  void save(const std::string& path) {
    device_.reset();
    if (!tap_ && !record_) return;
    std::ofstream out(path);
    write_device_bytes(tap_ ? tap_->finish() : record_->pieces(), out);
    out.close();
    if (!out) throw std::runtime_error(shown(path) + ": cannot be written");
    const bool cut = tap_ ? tap_->is_cut() : record_->is_cut();
    std::cout << "its bytes: " << shown(path) << (cut ? ", without the end" : "") << '\n';
  }

 private:
  std::unique_ptr<SerialTap> tap_;
  std::unique_ptr<ByteRecord> record_;
  std::unique_ptr<Device> device_;  // last: both of the above outlive it
};

void try_out(const TryOptions& options) {
  if (!options.yes && isatty(STDIN_FILENO) != 1) {
    throw UsageError(
        "each step is asked for at a terminal; for a script give --yes, which moves "
        "the device without asking");
  }
  if (!options.output.empty()) check_outputs({options.output}, {}, options.overwrite);
  const SessionConfig config = config_of(options);
  if (!is_agreed(nullptr, options,
                 "This opens the " + std::string(row_of(config.device.kind).name) +
                     " and reads it, without force. Begin?")) {
    return;
  }
  catch_stop_signals();
  RecordedDevice tried(config.device, !options.output.empty());
  const DeviceCaps caps = tried.device().caps();
  if (caps.causality == Causality::kAdmittance) {
    throw InputError("a device that is commanded a pose cannot be tried this way");
  }
  const SafetyLimits limits =
      build_servo_model(config, {caps.max_force, caps.max_torque, false}).limits;
  std::cout << one_line(tried.device().description()) << '\n';
  enter_realtime({.fifo_priority = config.realtime != 0 ? kServoPriority : 0});
  std::vector<TrialRow> rows;
  std::optional<ExitCode> stopped;
  try {
    rows = try_device(tried.device(), limits, config.servo_rate, options);
  } catch (const ExitCode& code) {
    stopped = code;
  }
  // what was said until Ctrl-C is worth as much
  tried.save(options.output);
  if (stopped) throw *stopped;
  const bool all_passed = std::ranges::all_of(
      rows, [](const TrialRow& row) { return row.verdict == Verdict::kPassed; });
  if (!all_passed) throw ExitCode{kExitFailed};
}

}  // namespace

void add_try_command(Command& devices, bool& ran) {
  const auto options = std::make_shared<TryOptions>();
  Command command = devices.subcommand(
      "try", "Try a new device in three guarded steps, from reading it to all of its force");
  command.option("KIND|CONFIG", options->what, "kind of the device, or a session file with it")
      .required();
  command.option("--path NODE", options->path, "serial port of the device");
  command.option("-o,--output FILE", options->output,
                 "write down the bytes of both sides, to send in");
  add_overwrite(command, options->overwrite);
  command.flag("-y,--yes", options->yes, "ask nothing: the device moves by itself");
  command.example("hapt devices try woodenhaptics --path /dev/ttyACM0 -o woody.bytes");
  command.action([options, &ran] {
    ran = true;
    try_out(*options);
  });
}

}  // namespace haptic
