// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/jitter_rows.h"

#include <algorithm>
#include <optional>

#include "clients/lab/support/median.h"

namespace haptic {
namespace {

constexpr double kGoalP50 = 1.25, kGoalP99 = 2;  // ratio to cyclictest, at most
constexpr double kGoalShared = 0.9;              // share of late wakes, at least
constexpr double kGoalHybridP99 = 1e-6;          // [s]; the hybrid clock spins before a deadline
constexpr const char* kPeer = "cyclictest";

double seconds_at(const Histogram& late, double percent) {
  return 1e-9 * static_cast<double>(late.percentile(percent));
}

template <typename Figure>
double median_of(const std::vector<JitterRound>& rounds, Figure figure) {
  std::vector<double> values;
  values.reserve(rounds.size());
  for (const JitterRound& round : rounds) values.push_back(figure(round));
  return median(values);
}

template <typename Count>
double sum_of(const std::vector<JitterRound>& rounds, Count count) {
  uint64_t sum = 0;
  for (const JitterRound& round : rounds) sum += count(round);
  return static_cast<double>(sum);
}

void add_percentile(Rows& rows, const std::vector<JitterRound>& rounds, double percent, double goal,
                    bool has_peer) {
  const std::string name = "wake p" + std::to_string(static_cast<int>(percent));
  const auto own = [&](const JitterRound& r) { return seconds_at(r.sleep.servo.late, percent); };
  const auto peer = [&](const JitterRound& r) { return seconds_at(r.peer.late, percent); };
  std::optional<double> peer_median;
  if (has_peer) peer_median = median_of(rounds, peer);
  rows.add_beside(name + ", median of the pairs", median_of(rounds, own), "s", kPeer, peer_median);
  if (!has_peer) return;
  const double ratio = median_of(rounds, [&](const JitterRound& r) { return own(r) / peer(r); });
  rows.add(name + " / cyclictest's, median of the pairs", ratio, "", at_most(goal));
}

void add_witness_rows(Rows& rows, const std::vector<JitterRound>& rounds) {
  SharedLateness sum;
  for (const JitterRound& round : rounds) {
    const SharedLateness one =
        compare_with_witness(round.sleep.servo.late_wakes, round.sleep.witness.late_wakes);
    sum.late += one.late;
    sum.shared += one.shared;
    sum.largest_private_ns = std::max(sum.largest_private_ns, one.largest_private_ns);
  }
  rows.add(
      {{"wakes later than 200 µs", sum.late}, {"of them shared with the witness", sum.shared}});
  if (sum.late == 0) return;
  const double share = static_cast<double>(sum.shared) / static_cast<double>(sum.late);
  rows.add(
      {{"share of them shared", share, "", at_least(kGoalShared)},
       {"latest that was not shared", 1e-9 * static_cast<double>(sum.largest_private_ns), "s"}});
}

}  // namespace

Rows make_jitter_rows(const std::vector<JitterRound>& rounds) {
  const std::string peer_problem = peer_problem_of(rounds);
  const RealtimeReport& rights = rounds.front().sleep.servo.rights;
  Rows rows("jitter", rights.fifo_errno == 0);
  const bool has_peer = peer_problem.empty();
  rows.note("machine", machine_line());
  rows.note("rights", rights.explain());
  if (!has_peer) rows.note("peer", peer_problem);

  add_percentile(rows, rounds, 50, kGoalP50, has_peer);
  add_percentile(rows, rounds, 99, kGoalP99, has_peer);
  const auto pooled = [&](const std::string& metric, auto own, auto peer) {
    std::optional<double> peer_sum;
    if (has_peer) peer_sum = sum_of(rounds, peer);
    rows.add_beside(metric, sum_of(rounds, own), "", kPeer, peer_sum);
  };
  pooled(
      "wakes", [](const JitterRound& r) { return r.sleep.servo.late.count(); },
      [](const JitterRound& r) { return r.peer.late.count(); });
  pooled(
      "wakes later than 100 µs", [](const JitterRound& r) { return r.sleep.servo.over_100us; },
      [](const JitterRound& r) { return r.peer.over_100us; });
  pooled(
      "wakes later than 1 ms", [](const JitterRound& r) { return r.sleep.servo.over_1ms; },
      [](const JitterRound& r) { return r.peer.over_1ms; });
  add_witness_rows(rows, rounds);

  const double hybrid_p99 =
      median_of(rounds, [](const JitterRound& r) { return seconds_at(r.hybrid.late, 99); });
  rows.add(
      {{"hybrid: wake p50, median of the pairs",
        median_of(rounds, [](const JitterRound& r) { return seconds_at(r.hybrid.late, 50); }), "s"},
       {"hybrid: wake p99, median of the pairs", hybrid_p99, "s", at_most(kGoalHybridP99)},
       {"hybrid: wakes later than 100 µs",
        sum_of(rounds, [](const JitterRound& r) { return r.hybrid.over_100us; })},
       {"hybrid: wakes later than 1 ms",
        sum_of(rounds, [](const JitterRound& r) { return r.hybrid.over_1ms; })}});
  return rows;
}

std::string peer_problem_of(const std::vector<JitterRound>& rounds) {
  for (const JitterRound& round : rounds) {
    if (!round.peer.problem.empty()) return round.peer.problem;
  }
  return "";
}

}  // namespace haptic
