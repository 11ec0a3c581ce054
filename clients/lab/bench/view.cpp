// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "clients/hapt/session_process.h"
#include "clients/lab/bench/live_session.h"
#include "clients/lab/bench/workloads/viewers.h"
#include "clients/lab/support/forked_process.h"
#include "clients/lab/support/measurement.h"
#include "proto/config/command_line.h"
#include "proto/ipc/sessions.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

constexpr double kMostBusy = 1.1;      // p99 of the servo's work, against that without viewers
constexpr double kMostOfCore = 0.1;    // of the bridge, with 64 viewers at 120 Hz
constexpr double kMostForOne = 0.005;  // of a core, for a viewer that stands still
constexpr const char* kSession = "bench-view";

struct Options {
  std::string config = "plane.toml";
  double seconds = 5;
  int viewers = 64, rounds = 5;
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
struct Window : SessionWindow {
  double bridge = 0;  // of a core
  double frames = 0;  // a second and viewer
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
        session_(folder_, kSession, find_session_file(options.config)),
        bridge_("haptic-view", {"view", kSession, "--port", "0", "--no-open"},
                folder_.path() + "/view.log") {
    wait_until("the bridge does not start",
               [&] { return (port_ = port_in(folder_.path() + "/view.log")) != 0; });
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
    const double cpu = cpu_of(bridge_.pid());
    const uint64_t frames = counts.frames;
    const SessionWindow seen = session_.watch(options_.seconds);
    return {seen, (cpu_of(bridge_.pid()) - cpu) / seen.seconds,
            static_cast<double>(counts.frames - frames) / seen.seconds};
  }

  const Options& options_;
  RuntimeFolder folder_;
  LiveSession session_;
  SessionProcess bridge_;
  uint16_t port_ = 0;
};

void add_case(const Case& one, const std::vector<Window>& windows, const std::vector<Window>& none,
              const Rows& all) {
  Rows rows = all.of(one.name);
  const double busy = median_of(windows, &Window::busy_p99);
  const double core = median_of(windows, &Window::bridge);
  rows.add({{"servo_busy_p99", busy, "s"},
            {"servo_wake_lateness_p99", median_of(windows, &Window::wake_p99), "s"}});
  if (one.viewers == 0) {
    rows.add("bridge_cpu", core, "cores");
    return;
  }
  rows.add("servo_busy_p99_ratio", busy / median_of(none, &Window::busy_p99), "",
           at_most(kMostBusy));
  if (one.viewers > 1) {
    rows.add({{"bridge_cpu", core, "cores", at_most(kMostOfCore)},
              {"frames_of_a_viewer", median_of(windows, &Window::frames), "Hz"}});
  } else {
    rows.add("bridge_cpu_more", core - median_of(none, &Window::bridge), "cores",
             at_most(kMostForOne));
  }
}

void all_rows(const Options& options, const Rows& all) {
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
  all.machine("machine");
  for (const Case& one : cases) add_case(one, windows[one.name], windows["none"], all);
}

}  // namespace

/// The cost of viewers of `hapt view`: the servo's work and the bridge's own time of the processor,
/// with none, with many at 120 Hz, with one that is stopped and with one that reads a byte now and
/// then, in turns in one session; a figure is the median over the rounds.
Measured bench_view(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--config FILE", options->config, "session file").show_default();
  add_counts(command, {{"--viewers", &options->viewers, "at 120 Hz", 2, 90}});
  command.quantity("--for", options->seconds, Dimension::kTime, {0.2, 3600}, "of each window", "s")
      .show_default();
  add_counts(command, {rounds_of(options->rounds, "of all cases in turn; medians are reported")});
  return measured(all_rows, options);
}

}  // namespace haptic
