// SPDX-License-Identifier: GPL-3.0-or-later
// hapt top: what each process of a session is doing now.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>

#include "clients/client.h"
#include "clients/hapt_commands.h"
#include "clients/realtime_line.h"
#include "clients/report.h"
#include "proto/process.h"

namespace haptic {
namespace {

constexpr int64_t kDeadAfter = 250'000'000;  // heartbeat older than this: not running [ns]

struct TopOptions {
  std::string session;
  double period = 1;  // [s]
  uint64_t screens = std::numeric_limits<uint64_t>::max();
  bool batch = false, json = false;
};

/// One process over one period. Negative: not known.
struct Line {
  std::string name;
  std::string state = "---";
  uint64_t generation = 0;
  double rate = 0;                                     // [Hz]
  double wait_p99 = -1, busy_p50 = -1, busy_p99 = -1;  // [s]
  uint64_t items = 0, lost = 0;
};

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return -1;
  const auto i =
      std::min(values.size() - 1, static_cast<size_t>(q * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i), values.end());
  return values[i];
}

std::string state_of(const SegmentHeader* header) {
  if (header == nullptr) return "---";
  if (now_ns() - header->heartbeat_ns.load() > kDeadAfter) return "stuck";
  switch (static_cast<SegmentState>(header->state.load())) {
    case SegmentState::kInit:
      return "start";
    case SegmentState::kRun:
      return "run";
    case SegmentState::kDrain:
      return "drain";
    case SegmentState::kDead:
      return "dead";
  }
  return "?";
}

/// Drains one ring into a line: `busy` and `wait` say what an item tells of its step [ns].
template <typename Source, typename Busy, typename Wait>
Line watch(const std::string& name, Source& source, double seconds, Busy busy, Wait wait,
           typename Source::Item& newest) {
  Line line;
  std::vector<double> busy_s, wait_s;
  typename Source::Item item;
  const uint64_t lost_before = source.lost();
  while (source.next(item)) {
    busy_s.push_back(static_cast<double>(busy(item)) * 1e-9);
    if (wait(item) >= 0) wait_s.push_back(static_cast<double>(wait(item)) * 1e-9);
    newest = item;
  }
  line.name = name;
  line.items = busy_s.size();
  line.lost = source.lost() - lost_before;
  line.state = state_of(source.header());
  line.generation = source.generation();
  line.rate = static_cast<double>(line.items + line.lost) / seconds;
  line.wait_p99 = quantile(wait_s, 0.99);
  line.busy_p50 = quantile(busy_s, 0.5);
  line.busy_p99 = quantile(busy_s, 0.99);
  return line;
}

std::string cell(double seconds) {
  return seconds < 0 ? "---" : readable(seconds, "s");
}

void print_screen(const std::vector<Line>& lines, const ServoFrame& frame,
                  const SegmentHeader* servo) {
  std::printf("%-9s %-6s %4s %9s %10s %10s %10s %6s\n", "process", "state", "gen", "rate Hz",
              "wait p99", "busy p50", "busy p99", "missed");
  for (const Line& l : lines) {
    // µ takes two bytes and one column
    const auto width = [](const std::string& s) {
      return 10 + static_cast<int>(std::count(s.begin(), s.end(), '\xc2'));
    };
    const std::string wait = cell(l.wait_p99), p50 = cell(l.busy_p50), p99 = cell(l.busy_p99);
    std::printf("%-9s %-6s %4llu %9.1f %*s %*s %*s %6llu\n", l.name.c_str(), l.state.c_str(),
                static_cast<unsigned long long>(l.generation), l.rate, width(wait), wait.c_str(),
                width(p50), p50.c_str(), width(p99), p99.c_str(),
                static_cast<unsigned long long>(l.lost));
  }
  std::printf("force %.2f N   depth %.2f mm   contacts %u   fade %.2f   skipped ticks %llu%s\n%s\n",
              norm(frame.F_device_B.f), 1e3 * frame.depth, frame.n_contacts, frame.fade,
              static_cast<unsigned long long>(frame.skipped),
              (frame.flags & kServoFault) != 0 ? "   FAULT" : "", realtime_line(servo).c_str());
}

void print_screen_json(const std::vector<Line>& lines, const ServoFrame& frame) {
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, const std::string& metric, double value,
                       const std::string& unit) {
    rows.push_back({name, metric, value, unit, "", {}, {}, {}});
  };
  for (const Line& l : lines) {
    add(l.name, "rate", l.rate, "Hz");
    add(l.name, "generation", static_cast<double>(l.generation), "");
    if (l.wait_p99 >= 0) add(l.name, "wake lateness p99", l.wait_p99, "s");
    if (l.busy_p50 >= 0) add(l.name, "busy p50", l.busy_p50, "s");
    if (l.busy_p99 >= 0) add(l.name, "busy p99", l.busy_p99, "s");
    add(l.name, "missed by this viewer", static_cast<double>(l.lost), "");
  }
  add("servo0", "force", norm(frame.F_device_B.f), "N");
  add("servo0", "skipped ticks", static_cast<double>(frame.skipped), "");
  print_json(std::cout, rows);
}

void run_top(const TopOptions& options) {
  catch_stop_signals();
  Client client(options.session);
  auto servo = client.ring<&ServoChannels::frames>(Start::kNewest);
  auto contact = client.ring<&ContactChannels::sets>(Start::kNewest);
  auto sim = client.ring<&SimChannels::frames>(Start::kNewest);
  client.start();

  ServoFrame frame{};
  ContactSet set{};
  SceneFrame scene{};
  int64_t last_ns = now_ns();
  for (uint64_t n = 0; n < options.screens && client.is_connected() && !stop_requested(); ++n) {
    client.sleep(options.period);
    const int64_t t_ns = now_ns();
    const double seconds = static_cast<double>(t_ns - last_ns) * 1e-9;
    last_ns = t_ns;
    const auto busy = [](const auto& item) { return item.busy_ns; };
    const auto no_wait = [](const auto&) { return int64_t{-1}; };
    const std::vector<Line> lines{watch(
                                      "servo0", servo, seconds, busy,
                                      [](const ServoFrame& f) { return f.wake_late_ns; }, frame),
                                  watch("contact0", contact, seconds, busy, no_wait, set),
                                  watch("sim", sim, seconds, busy, no_wait, scene)};
    if (options.json) {
      print_screen_json(lines, frame);
      continue;
    }
    if (!options.batch && isatty(STDOUT_FILENO) == 1) std::printf("\033[H\033[2J");
    print_screen(lines, frame, servo.header());
    std::fflush(stdout);
  }
  if (!client.is_connected()) std::cerr << "the session has ended\n";
}

}  // namespace

void add_top_command(CLI::App& app) {
  const auto options = std::make_shared<TopOptions>();
  CLI::App* command = app.add_subcommand("top", "Watch the processes of a running session");
  command->add_option("--session", options->session, "which one; default: the only one running");
  command->add_option("-d,--period", options->period, "seconds between two screens")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("-n", options->screens, "screens to print; default: until Ctrl-C");
  command->add_flag("-b,--batch", options->batch, "do not clear the screen in between");
  command->add_flag("--json", options->json, "rows as JSON, one array a screen");
  command->callback([options] { run_top(*options); });
}

}  // namespace haptic
