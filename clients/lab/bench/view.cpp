// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "clients/hapt/session_process.h"
#include "clients/lab/bench/benches.h"
#include "clients/lab/bench/live_session.h"
#include "clients/lab/bench/workloads/viewers.h"
#include "clients/lab/support/forked_process.h"
#include "clients/library/client.h"
#include "clients/report/median.h"
#include "proto/config/command_line.h"
#include "proto/ipc/sessions.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

constexpr double kMostBusy = 1.1;      // p99 of the servo's work, against that without viewers
constexpr double kMostOfCore = 0.1;    // of the bridge, with 64 viewers at 120 Hz
constexpr double kMostForOne = 0.005;  // of a core, for a viewer that stands still
constexpr int64_t kDrainPeriod = kNsPerSecond / 100;
constexpr const char* kSession = "bench-view";

struct Options {
  std::string config = "plane.toml";
  double seconds = 5;
  int viewers = 64, rounds = 0;
};

/// The port in the address that the bridge prints; 0: not yet.
uint16_t port_in(const std::string& log) {
  std::ostringstream text;
  text << std::ifstream(log).rdbuf();
  const std::string said = text.str(), head = "http://127.0.0.1:";
  const size_t at = said.find(head);
  if (at == said.npos || said.find('\n', at) == said.npos) return 0;
  return static_cast<uint16_t>(std::atoi(said.c_str() + at + head.size()));
}

/// Time of the processor that another process has taken [s].
double cpu_of(pid_t pid) {
  clockid_t clock;
  timespec t{};
  if (clock_getcpuclockid(pid, &clock) != 0 || clock_gettime(clock, &t) != 0) {
    throw std::runtime_error("bench view: the bridge has ended");
  }
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The measurements of one window of one case.
struct Window {
  double busy_p99 = 0, wake_p99 = 0;  // of the servo [s]
  double bridge = 0;                  // of a core
  double frames = 0;                  // a second and viewer
};

struct Case {
  const char* name;
  int viewers;
  ViewerKind kind;
  bool is_stopped;
};

/// A session with its bridge.
class Watched {
 public:
  explicit Watched(const Options& options)
      : options_(options),
        hapticd_("hapticd", {find_session_file(options.config), "--session", kSession},
                 folder_.path + "/hapticd.log") {
    wait_until("hapticd does not start", [&] { return !running_sessions().empty(); });
    bridge_.emplace("haptic-view",
                    std::vector<std::string>{"view", kSession, "--port", "0", "--no-open"},
                    folder_.path + "/view.log");
    wait_until("the bridge does not start",
               [&] { return (port_ = port_in(folder_.path + "/view.log")) != 0; });
    client_.emplace(kSession);
    frames_.emplace(client_->ring<&ServoChannels::frames>(Start::kNewest));
    client_->start();
    ServoFrame frame;
    wait_until("the servo does not run", [&] { return frames_->latest(frame); });
  }

  Window run(const Case& one) {
    Shared<ViewerCounts> counts;
    ForkedProcess viewers;
    if (one.viewers > 0) {
      viewers = ForkedProcess([&] { be_viewers(port_, one.viewers, one.kind, *counts); });
      wait_until("the viewers do not get in",
                 [&] { return counts->connected == static_cast<uint32_t>(one.viewers); });
    }
    if (one.is_stopped) viewers.signal(SIGSTOP);
    sleep_until(now_ns() + kNsPerSecond / 2);  // what connecting costs is none of it
    Window window = measure(*counts);
    if (one.viewers > 0) window.frames /= one.viewers;
    return window;
  }

 private:
  Window measure(const ViewerCounts& counts) {
    ServoFrame frame;
    frames_->latest(frame);
    const double cpu = cpu_of(bridge_->pid());
    const uint64_t frames = counts.frames;
    const int64_t begin = now_ns(), end = begin + static_cast<int64_t>(1e9 * options_.seconds);
    Histogram busy, wake;
    while (now_ns() < end) {
      sleep_until(now_ns() + kDrainPeriod);
      while (frames_->next(frame)) {
        busy.add(frame.busy_ns);
        wake.add(frame.wake_late_ns);
      }
    }
    const double seconds = 1e-9 * static_cast<double>(now_ns() - begin);
    return {1e-9 * static_cast<double>(busy.percentile(99)),
            1e-9 * static_cast<double>(wake.percentile(99)),
            (cpu_of(bridge_->pid()) - cpu) / seconds,
            static_cast<double>(counts.frames - frames) / seconds};
  }

  const Options& options_;
  RuntimeFolder folder_{"view"};
  SessionProcess hapticd_;
  std::optional<SessionProcess> bridge_;
  uint16_t port_ = 0;
  std::optional<Client> client_;
  std::optional<RingSource<&ServoChannels::frames>> frames_;
};

/// The median over the rounds of one quantity.
double median_of(const std::vector<Window>& windows, double Window::*quantity) {
  std::vector<double> values;
  for (const Window& window : windows) values.push_back(window.*quantity);
  return median(values);
}

std::vector<Row> rows_of(const Case& one, const std::vector<Window>& windows,
                         const std::vector<Window>& none) {
  Rows rows(one.name);
  const double busy = median_of(windows, &Window::busy_p99);
  const double core = median_of(windows, &Window::bridge);
  rows.add("servo_busy_p99", busy, "s");
  rows.add("servo_wake_lateness_p99", median_of(windows, &Window::wake_p99), "s");
  if (one.viewers == 0) {
    rows.add("bridge_cpu", core, "cores");
    return rows.rows();
  }
  rows.at_most("servo_busy_p99_ratio", busy / median_of(none, &Window::busy_p99), "", kMostBusy);
  if (one.viewers > 1) {
    rows.at_most("bridge_cpu", core, "cores", kMostOfCore);
    rows.add("frames_of_a_viewer", median_of(windows, &Window::frames), "Hz");
  } else {
    rows.at_most("bridge_cpu_more", core - median_of(none, &Window::bridge), "cores", kMostForOne);
  }
  return rows.rows();
}

std::vector<Row> all_rows(const Options& options) {
  Watched session(options);
  const std::vector<Case> cases{{"none", 0, ViewerKind::kPrompt, false},
                                {"viewers", options.viewers, ViewerKind::kPrompt, false},
                                {"stopped", 1, ViewerKind::kPrompt, true},
                                {"slow", 1, ViewerKind::kSlow, false}};
  std::map<std::string, std::vector<Window>> windows;
  Progress progress("measuring rounds", options.rounds);
  for (int round = 0; round < options.rounds; ++round) {
    for (const Case& one : cases) windows[one.name].push_back(session.run(one));
    progress.step();
  }
  Rows rows = machine_rows("machine");
  for (const Case& one : cases) rows.append(rows_of(one, windows[one.name], windows["none"]));
  return rows.rows();
}

}  // namespace

BenchRun bench_view(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--config FILE", options->config, "session file").show_default();
  command.option("--viewers", options->viewers, "at 120 Hz").range(2, 90).show_default();
  command.quantity("--for", options->seconds, Dimension::kTime, {0.2, 3600}, "of each window", "s")
      .show_default();
  return run_rounds(options, all_rows);
}

}  // namespace haptic
