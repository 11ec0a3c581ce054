// SPDX-License-Identifier: GPL-3.0-or-later
// hapt top: shows what each process of a session is doing.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <limits>
#include <optional>
#include <utility>

#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/hapt/realtime_line.h"
#include "clients/hapt/session_choice.h"
#include "clients/library/client.h"
#include "clients/report/report.h"
#include "proto/config/out_of_reach.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/wire/behind.h"

namespace haptic {
namespace {

constexpr int64_t kTopDrainPeriod = 50'000'000;  // [ns]
constexpr int64_t kAttachTime = kNsPerSecond;    // [ns]; segments are attached within milliseconds
constexpr int64_t kDeadAfter = 250'000'000;      // [ns]; age of a heartbeat that counts as stuck

struct TopOptions {
  SessionChoice session;
  uint32_t hand = kFirstHand;
  double period = 1;  // [s]
  uint64_t screens = std::numeric_limits<uint64_t>::max();
  bool batch = false, json = false;
};

// hapticd answers within milliseconds; while it does not, the rings fill [ns]
constexpr int64_t kStatusPatience = 40'000'000;
constexpr int64_t kAskPeriod = kNsPerSecond;  // however often the screen is drawn

/// One process over one period.
struct Line {
  std::string name;
  std::string state = "---";
  uint64_t generation = 0;
  double rate = 0;       // [Hz]
  Histogram wait, busy;  // [ns]
  uint64_t lost = 0;     // records overwritten before they were read
};

std::string state_of(const SegmentHeader* header) {
  if (header == nullptr) return "---";
  if (now_ns() - header->heartbeat_ns.load() > kDeadAfter) return "stuck";
  constexpr std::array kStates{"start", "run", "drain", "dead"};  // by SegmentState
  const uint32_t state = header->state.load();
  return state < kStates.size() ? kStates[state] : "?";
}

/// Watches one ring: drained often, reported once per period.
template <typename Source>
class Watched {
 public:
  using Item = typename Source::Item;

  /// `take`: what is looked at.
  Watched(std::string name, Source source, Take take = Take::kFields)
      : source_(source), take_(take) {
    line_.name = std::move(name);
  }

  void drain() {
    while (source_.next(newest, take_)) {
      ++items_;
      line_.busy.add(newest.busy_ns);
      if constexpr (requires(const Item& item) { item.wake_late_ns; }) {
        line_.wait.add(newest.wake_late_ns);
      }
    }
  }

  /// Ends this period, returns its figures and begins the next one.
  Line take(double seconds) {
    drain();
    Line out = std::move(line_);
    out.lost = source_.lost() - lost_before_;
    out.state = state_of(source_.header());
    out.generation = source_.generation();
    out.rate = static_cast<double>(items_ + out.lost) / seconds;
    line_ = {};
    line_.name = out.name;
    lost_before_ = source_.lost();
    items_ = 0;
    return out;
  }

  const SegmentHeader* header() { return source_.header(); }

  Item newest{};

 private:
  Source source_;
  Take take_;
  Line line_;
  uint64_t items_ = 0, lost_before_ = 0;
};

std::string cell(const Histogram& durations, double percent) {
  if (durations.count() == 0) return "---";
  return readable(1e-9 * static_cast<double>(durations.percentile(percent)), "s");
}

/// Answers of hapticd, which has the session's file; a client has not.
struct Asked {
  std::optional<OutOfReach> gone;   // none: hapticd does not answer
  std::vector<std::string> givers;  // a line each
};

/// Asks hapticd once a second.
class StatusAsked {
 public:
  explicit StatusAsked(std::string session) : session_(std::move(session)) {}

  const Asked& newest() {
    if (now_ns() - asked_ns_ < kAskPeriod) return asked_;
    asked_ns_ = now_ns();
    asked_ = {};
    try {
      const Json status = Json::parse(say_to_session(session_, "status", kStatusPatience));
      for (const Json& giver : status.at("giving")) {
        asked_.givers.push_back("'" + shown(giver.at("name").get<std::string>()) + "' " +
                                one_line(giver.at("text").get<std::string>()));
      }
      asked_.gone = {std::min(status.at("out_of_reach").get<uint32_t>(), kMaxObjects),
                     status.at("reach").get<double>()};
    } catch (const std::exception&) {
      // the screen is shown without it
    }
    return asked_;
  }

 private:
  std::string session_;
  Asked asked_;
  int64_t asked_ns_ = 0;
};

void print_screen(const std::vector<Line>& lines, const ServoFrame& frame,
                  const SegmentHeader* servo, const Asked& asked) {
  std::printf("%-9s %-6s %4s %9s %10s %10s %10s %6s\n", "process", "state", "gen", "rate Hz",
              "wait p99", "busy p50", "busy p99", "missed");
  for (const Line& l : lines) {
    // µ has two bytes and one column
    const auto width = [](const std::string& s) {
      return 10 + static_cast<int>(std::count(s.begin(), s.end(), '\xc2'));
    };
    const std::string wait = cell(l.wait, 99), p50 = cell(l.busy, 50), p99 = cell(l.busy, 99);
    std::printf("%-9s %-6s %4llu %9.1f %*s %*s %*s %6llu\n", l.name.c_str(), l.state.c_str(),
                static_cast<unsigned long long>(l.generation), l.rate, width(wait), wait.c_str(),
                width(p50), p50.c_str(), width(p99), p99.c_str(),
                static_cast<unsigned long long>(l.lost));
  }
  std::printf("force %.2f N   depth %.2f mm   contacts %u   fade %.2f   skipped ticks %llu%s\n%s\n",
              norm(frame.F_device_B.f), 1e3 * frame.depth, frame.n_contacts, frame.fade,
              static_cast<unsigned long long>(frame.skipped),
              (frame.flags & kServoFault) != 0 ? "   FAULT" : "", realtime_line(servo).c_str());
  for (const BehindRow& row : kBehind) {
    if ((frame.flags & row.flag) != 0) std::printf("%s falls behind\n", row.name);
  }
  for (const std::string& giver : asked.givers) std::printf("client %s\n", giver.c_str());
  if (asked.gone && asked.gone->bodies > 0) {
    std::printf("%s\n", out_of_reach_line(*asked.gone).c_str());
  }
}

/// {"p50": …, "p99": …, "max": …} in seconds; null where nothing was measured.
Json json_of(const Histogram& durations) {
  if (durations.count() == 0) return nullptr;
  const auto seconds = [](auto ns) { return 1e-9 * static_cast<double>(ns); };
  return {{"p50", seconds(durations.percentile(50))},
          {"p99", seconds(durations.percentile(99))},
          {"max", seconds(durations.max())}};
}

void print_screen_json(const std::vector<Line>& lines, const ServoFrame& frame, double seconds,
                       const Asked& asked) {
  Json processes = Json::object(), behind = Json::array();
  for (const Line& l : lines) {
    processes[l.name] = {{"state", l.state},          {"generation", l.generation},
                         {"rate_hz", l.rate},         {"wake_lateness_s", json_of(l.wait)},
                         {"busy_s", json_of(l.busy)}, {"missed", l.lost}};
  }
  for (const BehindRow& row : kBehind) {
    if ((frame.flags & row.flag) != 0) behind.push_back(row.name);
  }
  std::cout << json_line({{"seconds", seconds},
                          {"processes", processes},
                          {"force_n", norm(frame.F_device_B.f)},
                          {"depth_m", frame.depth},
                          {"contacts", frame.n_contacts},
                          {"fade", frame.fade},
                          {"skipped_ticks", frame.skipped},
                          {"fault", frame.fault},
                          {"behind", behind},
                          {"giving", asked.givers},
                          {"out_of_reach", asked.gone ? Json(asked.gone->bodies) : Json(nullptr)}})
            << std::endl;
}

void run_top(const TopOptions& options) {
  catch_stop_signals();
  const std::string& session = once_up(options.session);
  Client client(session);
  const uint32_t hand = options.hand;
  Watched servo(servo_name(hand), client.ring<&ServoChannels::frames>(Start::kNewest, hand));
  Watched contact(contact_name(hand), client.ring<&ContactChannels::sets>(Start::kNewest, hand));
  Watched sim(SimChannels::kName, client.ring<&SimChannels::frames>(Start::kNewest), Take::kAll);
  const auto drain_all = [&] {
    servo.drain();
    contact.drain();
    sim.drain();
  };
  const auto go_on = [&] { return client.is_connected() && !stop_requested(); };
  client.start();
  // segments are attached by another thread: records found at the first look belong to no period
  for (const int64_t start_ns = now_ns();
       go_on() && servo.header() == nullptr && now_ns() - start_ns < kAttachTime;) {
    drain_all();
    sleep_until(now_ns() + kTopDrainPeriod);
  }
  drain_all();
  servo.take(1), contact.take(1), sim.take(1);

  StatusAsked status(session);
  int64_t last_ns = now_ns();
  for (uint64_t n = 0; n < options.screens && go_on(); ++n) {
    const int64_t end_ns = last_ns + static_cast<int64_t>(options.period * kNsPerSecond);
    // often enough that the smallest ring cannot overflow
    while (go_on() && now_ns() < end_ns) {
      sleep_until(std::min(end_ns, now_ns() + kTopDrainPeriod));
      drain_all();
    }
    const int64_t t_ns = now_ns();
    const double seconds = static_cast<double>(t_ns - last_ns) * 1e-9;
    last_ns = t_ns;
    const std::vector<Line> lines{servo.take(seconds), contact.take(seconds), sim.take(seconds)};
    Asked asked = status.newest();
    if (sim.newest.responses.empty()) asked.gone = OutOfReach{};
    if (options.json) {
      print_screen_json(lines, servo.newest, seconds, asked);
      continue;
    }
    if (!options.batch && isatty(STDOUT_FILENO) == 1) std::printf("\033[H\033[2J");
    print_screen(lines, servo.newest, servo.header(), asked);
    std::fflush(stdout);
  }
  if (client.is_connected()) return;
  if (!client.refusal().empty()) throw HandoutError(client.refusal());
  std::cerr << "the session has ended\n";
}

}  // namespace

void add_top_command(Command& app) {
  add_command<TopOptions>(
      app, "top", "Watch the processes of a running session", run_top,
      [](Command& command, TopOptions& options) {
        add_session(command, options.session);
        add_hand(command, options.hand);
        add_duration(command, "-d,--period", options.period, "between two screens").show_default();
        command.option("-n", options.screens, "screens to print")
            .range(1, 1000000)
            .show_default("until Ctrl-C");
        command.flag("-b,--batch", options.batch, "do not clear the screen in between");
        command.flag("--json", options.json,
                     "for scripts: one JSON object per screen, in one line");
        command.example("hapt top -n 1 --json");
      });
}

}  // namespace haptic
