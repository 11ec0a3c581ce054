// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/jitter_rows.h"

#include <algorithm>
#include <array>
#include <optional>

#include "clients/lab/support/median.h"

namespace haptic {
namespace {

constexpr double kGoalP50 = 1.25, kGoalP99 = 2;  // ratio to cyclictest, at most
constexpr double kGoalShared = 0.9;              // share of late wakes, at least
constexpr double kGoalHybridP99 = 1e-6;          // [s]; the hybrid clock spins before a deadline
constexpr const char* kPeer = "cyclictest";
constexpr std::array<std::pair<const char*, uint64_t Lateness::*>, 3> kCounts{
    {{"wakes", nullptr},
     {"wakes later than 100 µs", &Lateness::over_100us},
     {"wakes later than 1 ms", &Lateness::over_1ms}}};

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

/// The sum over runs of a count, or of all wakes.
double sum_of(const std::vector<const Lateness*>& runs, uint64_t Lateness::*count) {
  uint64_t sum = 0;
  for (const Lateness* run : runs) sum += count == nullptr ? run->late.count() : run->*count;
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

void add_jitter_rows(const std::vector<JitterRound>& rounds, const Rows& all) {
  const std::string peer_problem = peer_problem_of(rounds);
  const RealtimeReport& rights = rounds.front().sleep.servo.rights;
  Rows rows = all.of("jitter", rights.fifo_errno == 0);
  const bool has_peer = peer_problem.empty();
  rows.note("machine", machine_line());
  rows.note("rights", rights.explain());
  if (!has_peer) rows.note("peer", peer_problem);

  add_percentile(rows, rounds, 50, kGoalP50, has_peer);
  add_percentile(rows, rounds, 99, kGoalP99, has_peer);
  std::vector<const Lateness*> servo, peer, hybrid;
  for (const JitterRound& round : rounds) {
    servo.push_back(&round.sleep.servo), peer.push_back(&round.peer);
    hybrid.push_back(&round.hybrid);
  }
  for (const auto& [metric, count] : kCounts) {
    rows.add_beside(metric, sum_of(servo, count), "", kPeer,
                    has_peer ? std::optional(sum_of(peer, count)) : std::nullopt);
  }
  add_witness_rows(rows, rounds);

  const double hybrid_p99 =
      median_of(rounds, [](const JitterRound& r) { return seconds_at(r.hybrid.late, 99); });
  rows.add(
      {{"hybrid: wake p50, median of the pairs",
        median_of(rounds, [](const JitterRound& r) { return seconds_at(r.hybrid.late, 50); }), "s"},
       {"hybrid: wake p99, median of the pairs", hybrid_p99, "s", at_most(kGoalHybridP99)},
       {"hybrid: wakes later than 100 µs", sum_of(hybrid, &Lateness::over_100us)},
       {"hybrid: wakes later than 1 ms", sum_of(hybrid, &Lateness::over_1ms)}});
}

std::string peer_problem_of(const std::vector<JitterRound>& rounds) {
  for (const JitterRound& round : rounds) {
    if (!round.peer.problem.empty()) return round.peer.problem;
  }
  return "";
}

}  // namespace haptic
