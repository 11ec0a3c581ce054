// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench_jitter.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <thread>
#include <vector>

#include "clients/cyclictest.h"
#include "clients/report.h"
#include "clients/wake_lateness.h"

namespace haptic {
namespace {

constexpr double kGoalP50 = 1.25, kGoalP99 = 2;  // × cyclictest
constexpr double kGoalShared = 0.9;
constexpr double kGoalHybridP99 = 1e-6;  // [s]
constexpr const char* kPeer = "cyclictest";

struct JitterOptions {
  int pairs = 5;
  double seconds = 15;
  int core = static_cast<int>(std::max(1u, std::thread::hardware_concurrency())) - 1;
  bool json = false;
};

/// One round of windows, one after the other.
struct Round {
  WitnessedRun sleep;
  CyclictestRun peer;
  WakeRun hybrid;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

double seconds_at(const Histogram& late, double percent) {
  return 1e-9 * static_cast<double>(late.percentile(percent));
}

template <typename Figure>
double median_of(const std::vector<Round>& rounds, Figure figure) {
  std::vector<double> values;
  for (const Round& round : rounds) values.push_back(figure(round));
  return median(values);
}

template <typename Count>
double sum_of(const std::vector<Round>& rounds, Count count) {
  uint64_t sum = 0;
  for (const Round& round : rounds) sum += count(round);
  return static_cast<double>(sum);
}

std::vector<Round> measure(const JitterOptions& options) {
  std::vector<Round> rounds;
  for (int i = 0; i < options.pairs; ++i) {
    WakeOptions wake{.seconds = options.seconds, .core = options.core};
    Round round;
    // who comes first changes, so that a drift of the machine favours neither
    if (i % 2 == 1) round.peer = run_cyclictest(options.seconds, options.core);
    round.sleep = measure_witnessed_wakes(wake);
    if (i % 2 == 0) round.peer = run_cyclictest(options.seconds, options.core);
    wake.spin_ns = kHybridSpinNs;
    round.hybrid = measure_wakes(wake);
    rounds.push_back(std::move(round));
    std::cerr << "pair " << i + 1 << " of " << options.pairs << " measured\n";
  }
  return rounds;
}

/// A figure beside its peer's, which is null where there is none.
void add_beside(Rows& rows, const std::string& metric, double value, const std::string& unit,
                const std::optional<double>& peer) {
  Row row;
  row.case_name = "jitter";
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.peer = kPeer;
  row.peer_value = peer;
  rows.append({row});
}

/// A figure with a goal, judged only where the comparison is fair.
void add_judged(Rows& rows, const std::string& metric, double value, const std::string& unit,
                double goal, bool holds, bool fair) {
  if (fair) {
    rows.add(metric, value, unit, goal, holds);
  } else {
    rows.add(metric, value, unit);
  }
}

void add_percentile(Rows& rows, const std::vector<Round>& rounds, double percent, double goal,
                    bool has_peer, bool fair) {
  const std::string name = "wake p" + std::to_string(static_cast<int>(percent));
  const auto own = [&](const Round& r) { return seconds_at(r.sleep.servo.late, percent); };
  const auto peer = [&](const Round& r) { return seconds_at(r.peer.late, percent); };
  std::optional<double> peer_median;
  if (has_peer) peer_median = median_of(rounds, peer);
  add_beside(rows, name + ", median of the pairs", median_of(rounds, own), "s", peer_median);
  if (!has_peer) return;
  const double ratio = median_of(rounds, [&](const Round& r) { return own(r) / peer(r); });
  add_judged(rows, name + " / cyclictest's, median of the pairs", ratio, "", goal, ratio <= goal,
             fair);
}

void add_witness_rows(Rows& rows, const std::vector<Round>& rounds, bool fair) {
  SharedLateness sum;
  for (const Round& round : rounds) {
    const SharedLateness one =
        compare_with_witness(round.sleep.servo.late_wakes, round.sleep.witness.late_wakes);
    sum.late += one.late;
    sum.shared += one.shared;
    sum.largest_private_ns = std::max(sum.largest_private_ns, one.largest_private_ns);
  }
  rows.add("wakes later than 200 µs", static_cast<double>(sum.late), "");
  rows.add("of them shared with the witness", static_cast<double>(sum.shared), "");
  if (sum.late == 0) return;
  const double share = static_cast<double>(sum.shared) / static_cast<double>(sum.late);
  add_judged(rows, "share of them shared", share, "", kGoalShared, share >= kGoalShared, fair);
  rows.add("latest that was not shared", 1e-9 * static_cast<double>(sum.largest_private_ns), "s");
}

Rows make_rows(const std::vector<Round>& rounds, const std::string& peer_problem) {
  Rows rows("jitter");
  const RealtimeReport& rights = rounds.front().sleep.servo.rights;
  const bool fair = rights.fifo_errno == 0 && rounds.front().sleep.servo.pin_errno == 0;
  const bool has_peer = peer_problem.empty();
  rows.note("machine", machine_line());
  rows.note("rights", rights.explain());
  if (!has_peer) rows.note("peer", peer_problem);

  add_percentile(rows, rounds, 50, kGoalP50, has_peer, fair);
  add_percentile(rows, rounds, 99, kGoalP99, has_peer, fair);
  const auto pooled = [&](const std::string& metric, auto own, auto peer) {
    std::optional<double> peer_sum;
    if (has_peer) peer_sum = sum_of(rounds, peer);
    add_beside(rows, metric, sum_of(rounds, own), "", peer_sum);
  };
  pooled(
      "wakes", [](const Round& r) { return r.sleep.servo.late.count(); },
      [](const Round& r) { return r.peer.late.count(); });
  pooled(
      "wakes later than 100 µs", [](const Round& r) { return r.sleep.servo.over_100us; },
      [](const Round& r) { return r.peer.over_100us; });
  pooled(
      "wakes later than 1 ms", [](const Round& r) { return r.sleep.servo.over_1ms; },
      [](const Round& r) { return r.peer.over_1ms; });
  add_witness_rows(rows, rounds, fair);

  const double hybrid_p99 =
      median_of(rounds, [](const Round& r) { return seconds_at(r.hybrid.late, 99); });
  rows.add("hybrid: wake p50, median of the pairs",
           median_of(rounds, [](const Round& r) { return seconds_at(r.hybrid.late, 50); }), "s");
  add_judged(rows, "hybrid: wake p99, median of the pairs", hybrid_p99, "s", kGoalHybridP99,
             hybrid_p99 <= kGoalHybridP99, fair);
  rows.add("hybrid: wakes later than 100 µs",
           sum_of(rounds, [](const Round& r) { return r.hybrid.over_100us; }), "");
  rows.add("hybrid: wakes later than 1 ms",
           sum_of(rounds, [](const Round& r) { return r.hybrid.over_1ms; }), "");
  return rows;
}

void run_jitter(const JitterOptions& options) {
  const std::vector<Round> rounds = measure(options);
  std::string problem;
  for (const Round& round : rounds) {
    if (problem.empty()) problem = round.peer.problem;
  }
  const Rows rows = make_rows(rounds, problem);
  if (!problem.empty()) std::cerr << "hapt: " << problem << '\n';
  if (rounds.front().sleep.servo.rights.fifo_errno != 0) {
    std::cerr << "hapt: " << rounds.front().sleep.servo.rights.explain()
              << "; the goals are not judged\n";
  }
  if (options.json) {
    print_json(std::cout, rows.rows());
  } else {
    print_table(std::cout, rows.rows());
  }
  std::cout.flush();
  if (!all_hold(rows.rows())) throw CLI::RuntimeError(1);
}

}  // namespace

void add_bench_jitter(CLI::App& bench) {
  const auto options = std::make_shared<JitterOptions>();
  CLI::App* command = bench.add_subcommand(
      "jitter", "How late the servo's clock wakes, beside cyclictest, in alternation");
  command->add_option("--pairs", options->pairs, "rounds of servo, cyclictest and hybrid")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "of each window")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->add_option("--core", options->core, "they all run on")
      ->check(CLI::Range(0, 1023))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { run_jitter(*options); });
}

}  // namespace haptic
