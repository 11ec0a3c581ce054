// SPDX-License-Identifier: GPL-3.0-or-later
// hapt torture: injects random faults into a private session and checks every force in the log of
// the emulated device.
#include <sched.h>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <utility>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/hapt/scratch_folder.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/torture/account.h"
#include "clients/lab/torture/faults.h"
#include "clients/report/report.h"
#include "proto/config/command_line.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr double kFaultsPerMinute = 100;       // goal, at least
constexpr double kFaultsWithBodies = 80;       // a block that is lost is taken again in 0.7 s
constexpr double kFaultsWithGiven = 60;        // a client comes again after a second
constexpr int64_t kProgressNs = kNsPerSecond;  // between two progress lines
constexpr int kExitInterrupted = 130;          // 128 + SIGINT

struct TortureCommand {
  double seconds = 60;
  double minutes() const { return seconds / 60; }
  uint64_t seed = 1;
  std::string output;
  bool json = false, keep = false, overwrite = false, no_realtime = false, six = false,
       bodies = false, given = false;

  TortureOptions session(const std::string& folder, const std::string& recording) const {
    return {folder, recording, !no_realtime, six, bodies, given};
  }
};

/// Results of one kind of fault.
struct Tally {
  uint64_t count = 0, violated = 0, excused = 0;
  std::optional<int64_t> worst_zero_ns, worst_recovery_ns;
  std::string left_out;

  void add(const FaultOutcome& outcome) {
    if (!outcome.left_out.empty()) {
      left_out = outcome.left_out;
      return;
    }
    ++count;
    violated += outcome.violations.empty() ? 0 : 1;
    excused += outcome.excused;
    worst_zero_ns = std::max(worst_zero_ns, outcome.zero_after_ns);
    worst_recovery_ns = std::max(worst_recovery_ns, outcome.recovery_ns);
  }
};

struct Result {
  std::vector<Tally> tallies{all_faults().size()};
  SampleAccount samples;
  uint64_t faults = 0, violations = 0, between = 0, unseen = 0;
  double minutes = 0;
  bool interrupted = false;
  std::string broken;  // why it ended early; empty if it did not
};

/// The order of faults: hundreds shuffled by the seed, each with every kind in its proportion. A
/// kind that is not ready yet is drawn later.
class Deck {
 public:
  Deck(uint64_t seed, TortureOptions options) : random_(seed), options_(std::move(options)) {}

  FaultKind draw(const FaultInjector& injector) {
    for (;;) {
      const auto ready = std::find_if(cards_.begin(), cards_.end(), [&](FaultKind kind) {
        return injector.ready_ns(kind) <= now_ns();
      });
      if (ready != cards_.end()) {
        const FaultKind kind = *ready;
        cards_.erase(ready);
        return kind;
      }
      refill();
    }
  }

 private:
  void refill() {
    std::vector<FaultKind> fresh;
    for (const FaultInfo& info : all_faults()) {
      if (!is_possible(info, options_)) continue;
      fresh.insert(fresh.end(), static_cast<size_t>(info.share), info.kind);
    }
    std::shuffle(fresh.begin(), fresh.end(), random_);
    cards_.insert(cards_.end(), fresh.begin(), fresh.end());
  }

  std::mt19937_64 random_;
  TortureOptions options_;
  std::deque<FaultKind> cards_;
};

/// A line that overwrites itself on a terminal and is printed every ten seconds elsewhere.
class Progress {
 public:
  explicit Progress(double total_minutes) : total_minutes_(total_minutes) {}

  void show(const Result& result, bool last) {
    if (!last && now_ns() - shown_ns_ < (terminal_ ? 1 : 10) * kProgressNs) return;
    shown_ns_ = now_ns();
    std::fprintf(
        stderr, "%s%4.1f of %.1f min   %llu faults   %llu with violations%s", terminal_ ? "\r" : "",
        result.minutes, total_minutes_, static_cast<unsigned long long>(result.faults),
        static_cast<unsigned long long>(result.violations), terminal_ && !last ? "\033[K" : "\n");
  }

 private:
  double total_minutes_;
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  int64_t shown_ns_ = 0;
};

void take_in(const FaultOutcome& outcome, Result& result) {
  result.tallies[static_cast<size_t>(outcome.kind)].add(outcome);
  if (!outcome.left_out.empty()) return;
  const auto say = [](const std::string& where, const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      std::cerr << (isatty(STDERR_FILENO) == 1 ? "\n" : "") << "VIOLATION " << where << ": "
                << one_line(line) << '\n';
    }
  };
  say("after fault " + std::to_string(result.faults), outcome.before);
  ++result.faults;
  say("in fault " + std::to_string(result.faults) + ", " + std::string(info_of(outcome.kind).name),
      outcome.violations);
  result.between += outcome.before.size();
  result.violations += outcome.violations.empty() ? 0 : 1;
}

/// Appends one line per fault to faults.csv, which --keep preserves.
void write_down(std::ofstream& file, const FaultOutcome& o) {
  const auto ms = [](const std::optional<int64_t>& ns) {
    return ns ? std::to_string(1e-6 * static_cast<double>(*ns)) : std::string();
  };
  file << o.begin_ns << ',' << info_of(o.kind).name << ',' << ms(o.zero_after_ns) << ','
       << ms(o.recovery_ns) << ',' << o.excused << ',' << o.violations.size() << std::endl;
}

/// Writes the stalls measured by the witnesses next to the faults.
void write_down(const std::string& path, const std::vector<Stall>& stalls) {
  std::ofstream file(path);
  file << "t_ns,length_ms\n";
  for (const Stall& s : stalls) {
    file << s.begin_ns << ',' << 1e-6 * static_cast<double>(s.end_ns - s.begin_ns) << '\n';
  }
}

/// Injects faults until the time is over.
void torture(const TortureCommand& options, TortureSession& session, Result& result) {
  FaultInjector injector(session, options.seed);
  Deck deck(options.seed, options.session("", ""));
  std::ofstream log(session.folder() + "/faults.csv");
  log << "t_ns,fault,zero_after_ms,whole_after_ms,excused,violations\n";
  Progress progress(options.minutes());
  const int64_t begin_ns = now_ns();
  while (result.minutes < options.minutes() && result.broken.empty()) {
    result.interrupted = stop_requested();
    if (result.interrupted) break;
    try {
      const FaultOutcome outcome = injector.inject(deck.draw(injector));
      take_in(outcome, result);
      write_down(log, outcome);
    } catch (const std::runtime_error& error) {
      result.broken = error.what();
    }
    result.minutes = static_cast<double>(now_ns() - begin_ns) / (60.0 * kNsPerSecond);
    progress.show(result, false);
  }
  progress.show(result, true);
  write_down(session.folder() + "/stalls.csv", session.stalls(begin_ns, true));
}

double seconds(int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

/// The results as rows: one case per kind, and the totals.
std::vector<Row> make_rows(const TortureCommand& options, const Result& result) {
  const Rows all;
  for (const FaultInfo& info : all_faults()) {
    if (!is_possible(info, options.session("", ""))) continue;
    const Tally& tally = result.tallies[static_cast<size_t>(info.kind)];
    Rows rows = all.of(std::string(info.name));
    rows.add(
        {{"faults", tally.count}, {"faults with violations", tally.violated, "", kMustBeZero}});
    if (tally.worst_zero_ns) rows.add("worst time to zero", seconds(*tally.worst_zero_ns), "s");
    if (tally.worst_recovery_ns) {
      rows.add("worst time to whole", seconds(*tally.worst_recovery_ns), "s");
    }
    if (tally.excused > 0) {
      rows.add("commands excused by the machine", tally.excused);
    }
    if (!tally.left_out.empty()) rows.note("LEFT OUT", tally.left_out);
  }
  const double per_minute = options.bodies  ? kFaultsWithBodies
                            : options.given ? kFaultsWithGiven
                                            : kFaultsPerMinute;
  const double goal = std::floor(per_minute * options.minutes());
  Rows totals = all.machine("torture");
  totals.add({{"faults", static_cast<double>(result.faults), "",
               given(goal, result.interrupted || static_cast<double>(result.faults) >= goal)},
              {"faults with violations", result.violations, "", kMustBeZero},
              {"violations between two faults", result.between, "", kMustBeZero}});
  const SampleAccount& s = result.samples;
  totals.add({{"servo frames published", s.published},
              {"recorded", s.recorded},
              {"not recorded, explained", s.explained},
              {"not recorded, unexplained", s.unexplained, "", kMustBeZero},
              {"lost by recorders, all rings", s.told, "", kMustBeZero},
              {"missed by this program", result.unseen, "", kMustBeZero}});
  for (const std::string& why : s.unreadable) {
    totals.add("a recording cannot be read: " + why, 1, "", given(0, false));
  }
  return all.rows();
}

std::string cell(const std::optional<int64_t>& ns) {
  return ns ? readable(seconds(*ns), "s") : "–";
}

/// The documented effect of a kind of fault, in words.
std::string stated(const FaultInfo& info) {
  // in the order of Effect
  constexpr std::array kWords{"within limits, no fast rise",
                              "within limits",
                              "nothing changes",
                              "zero in 150 ms",
                              "zero in ",
                              "zero first on return"};
  std::string text = kWords[static_cast<size_t>(info.effect)];
  if (info.effect == Effect::kZero) text += readable(seconds(info.zero_ns), "s");
  if (info.goal_ns != 0) text += ", whole in " + readable(seconds(info.goal_ns), "s");
  return text;
}

void print_kinds(const Result& result, const TortureOptions& options) {
  constexpr std::array<size_t, 7> kWidths{32, 7, 12, 15, 16, 9, 0};
  const auto line = [&](const std::array<std::string, 7>& cells) {
    for (size_t i = 0; i < cells.size(); ++i) std::cout << padded(cells[i], kWidths[i]);
    std::cout << '\n';
  };
  line({"fault", "count", "violations", "worst to zero", "worst to whole", "excused", "stated"});
  for (const FaultInfo& info : all_faults()) {
    if (!is_possible(info, options)) continue;
    const Tally& tally = result.tallies[static_cast<size_t>(info.kind)];
    line({std::string(info.name), std::to_string(tally.count), std::to_string(tally.violated),
          cell(tally.worst_zero_ns), cell(tally.worst_recovery_ns), std::to_string(tally.excused),
          tally.left_out.empty() ? stated(info) : "LEFT OUT: " + tally.left_out});
  }
}

void print(const TortureCommand& options, const Result& result, const std::vector<Row>& rows) {
  if (options.json) return print_json(std::cout, rows);
  print_kinds(result, options.session("", ""));
  std::vector<Row> totals;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(totals),
               [](const Row& row) { return row.case_name == "torture"; });
  print_table(std::cout, totals);
}

void run_torture(const TortureCommand& options) {
  if (options.six && options.bodies) {
    throw UsageError("--six, --bodies: the block is taken with one button and no wrist; give one");
  }
  if (options.given && (options.six || options.bodies)) {
    throw UsageError(
        "--given: a client moves the block of the device with three motors; give it alone");
  }
  std::string recording = options.output;
  if (recording.ends_with(".mcap")) recording.resize(recording.size() - 5);
  if (!recording.empty()) {
    check_outputs({recording + ".mcap", recording + "-2.mcap"}, {}, options.overwrite);
  }
  catch_stop_signals();
  const ScratchFolder folder(options.keep);
  if (recording.empty()) recording = folder.path() + "/torture";
  Result result;
  {
    TortureSession session(options.session(folder.path(), recording));
    // it has to see every frame, while 64 viewers may take both processors
    if (!options.no_realtime)
      enter_realtime({.fifo_priority = kTorturePriority, .lock_memory = false});
    torture(options, session, result);
    session.stop();
    // what is left is work, which a real-time thread may not do for seconds
    const sched_param normal{};
    sched_setscheduler(0, SCHED_OTHER, &normal);
    result.unseen = session.unseen();
    result.samples = account_for_samples(session.parts(), session.published());
  }
  const std::vector<Row> rows = make_rows(options, result);
  print(options, result, rows);
  std::cout.flush();
  if (options.keep)
    std::cerr << "what was received, recorded and said is in " << folder.path() << '\n';
  if (!result.broken.empty()) throw std::runtime_error(result.broken);
  if (!all_hold(rows)) throw ExitCode{1};
  if (result.interrupted) throw ExitCode{kExitInterrupted};
}

}  // namespace

void add_torture_command(Command& app) {
  const auto options = std::make_shared<TortureCommand>();
  Command command = add_elsewhere(app, "torture");
  command.footer(
      "Starts an emulated device whose hand presses into a block, a session on it and a recorder, "
      "in a temporary folder. Then kills, stops, slows and misleads them one after the other, some "
      "hundred times a minute, and waits each time until the hand feels the spring again. Every "
      "force is read from the device's own log.");
  command
      .quantity("--minutes", options->seconds, Dimension::kTime, {3, 6e5},
                "how long, as 30s or 1h; a number without unit is in minutes", "min")
      .show_default("1 min");
  command.option("--seed", options->seed, "of the order of the faults").show_default();
  command.option("-o,--output FILE", options->output,
                 "keep the recordings: FILE.mcap, FILE-2.mcap after the first restart, …");
  add_overwrite(command, options->overwrite);
  command.flag("--six", options->six,
               "on a device with six motors: each torque is checked as each force is");
  command.flag("--bodies", options->bodies,
               "what is touched has mass, and the hand holds it in every other turn");
  command.flag("--given", options->given,
               "a client moves what is touched, and is killed, stopped and corrupted too");
  command.flag("--keep", options->keep, "keep the folder with the device's log");
  command.flag("--no-realtime", options->no_realtime, "run without real-time priorities");
  add_json(command, options->json);
  command.example("hapt torture --minutes 10 --seed 3");
  command.action([options] { run_torture(*options); });
}

}  // namespace haptic
