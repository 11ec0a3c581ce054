// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/lab/bench/peers/depth.h"
#include "clients/lab/bench/workloads/convex_pairs.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/selftest/rt_guard.h"
#include "clients/lab/support/measurement.h"
#include "contact/bake/convex/hull_of_points.h"
#include "contact/query/convex/closest_features.h"
#include "contact/query/convex/expanding_polytope.h"
#include "contact/query/convex/penetration_depth.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

constexpr size_t kChunk = 100;   // queries of one contestant per turn
constexpr double kSame = 1e-12;  // depths that differ by less are the same [m]
constexpr double kWrong = 1e-6;  // an error of a peer that counts, beside 1 % of the depth [m]
constexpr double kApart = 6e-3;  // what moves the poses of W4 apart by some millimetres [m]

struct Options {
  int rounds = 5;
  size_t poses = 2000;
};

/// A pair of W4 and its poses.
struct Work {
  uint32_t n;
  HullData data_a, data_b;
  Hull a, b;
  std::vector<Pose> poses;

  Work(uint32_t vertices, size_t n_poses)
      : n(vertices),
        data_a(hull_of_points(make_convex_points(n, convex_seed_A(n))).hull),
        data_b(hull_of_points(make_convex_points(n, convex_seed_B(n))).hull),
        a(data_a.view()),
        b(data_b.view()),
        poses(make_convex_poses(a, b, n_poses)) {}
  Work(const Work&) = delete;

  std::string name() const { return std::to_string(n) + " x " + std::to_string(n); }
};

/// Enters the peers after the subject, which is the first.
std::vector<std::vector<double>> enter_peers(std::vector<Contestant>& contestants,
                                             const std::vector<HullPeer>& peers,
                                             const std::vector<Pose>& poses) {
  std::vector<std::vector<double>> answers(peers.size(), std::vector<double>(poses.size()));
  for (size_t k = 0; k < peers.size(); ++k) {
    contestants.push_back({peers[k].name, [answer = peers[k].answer, out = answers[k].data(),
                                           &poses](size_t i) { out[i] = answer(poses[i]); }});
  }
  return answers;
}

void add_peers(Rows& rows, const std::vector<Contestant>& contestants,
               const std::vector<std::vector<double>>& answers, const std::vector<double>& exact) {
  for (size_t k = 0; k < answers.size(); ++k) {
    const Contestant& peer = contestants[k + 1];
    const std::vector<double> times = fastest(peer, exact.size());
    rows.add({{peer.name + " p50", percentile(times, 50), "s"},
              {peer.name + " p99", percentile(times, 99), "s"}});
    size_t wrong = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
      wrong += std::fabs(answers[k][i] - exact[i]) > 0.01 * exact[i] + kWrong;
    }
    rows.add(peer.name + ", off by 1 % + 1 um", wrong);
  }
}

/// Rows of the depths found by the walk against those of the polytope, which are exact.
void add_truth(Rows& rows, const std::vector<PenetrationDepth>& found,
               const std::vector<double>& exact, const std::vector<double>& times) {
  size_t below = 0, equal = 0, fell_back = 0, n_steps = 0;
  double most = 0, longest = 0;
  for (size_t i = 0; i < exact.size(); ++i) {
    below += found[i].depth < exact[i] - kSame;
    equal += found[i].depth <= exact[i] + kSame;
    most = std::max(most, found[i].depth - exact[i]);
    n_steps += static_cast<size_t>(found[i].n_steps);
    fell_back += found[i].fell_back;
    if (found[i].fell_back) longest = std::max(longest, times[i]);
  }
  const auto n = static_cast<double>(exact.size());
  rows.add({{"below the exact depth", below, "", kMustBeZero},
            {"equal to the exact depth", static_cast<double>(equal) / n, "", at_least(0.99)},
            {"most above the exact depth", most, "m"},
            {"marching steps, mean", static_cast<double>(n_steps) / n, "", at_most(4)},
            {"exact fallbacks", static_cast<double>(fell_back) / n, "", at_most(0.005)},
            {"longest query with a fallback", longest, "s"}});
}

size_t allocations(const Work& work) {
  ConvexPairState state;
  return allocations_of([&] {
    for (const Pose& X_AB : work.poses) penetration_depth(HullPair(work.a, work.b, X_AB), state);
  });
}

void bench_depth(const Work& work, int rounds, const Rows& all) {
  const size_t n = work.poses.size();
  std::vector<double> exact(n), polytope(n);
  std::vector<PenetrationDepth> found(n);
  ConvexPairState state;
  std::vector<Contestant> contestants{{"walk", [&](size_t i) {
                                         if (i == 0) state = {};  // each round is the same
                                         found[i] = penetration_depth(
                                             HullPair(work.a, work.b, work.poses[i]), state);
                                       }}};
  const std::vector<HullPeer> peers = depth_peers(work.a, work.b);
  const auto answers = enter_peers(contestants, peers, work.poses);
  contestants.push_back({"polytope, always", [&](size_t i) {
                           exact[i] =
                               expand_polytope(HullPair(work.a, work.b, work.poses[i])).depth;
                         }});
  take_turns(contestants, n, kChunk, rounds);

  Rows rows = all.of("depth, " + work.name());
  const std::vector<double> times = fastest(contestants[0], n);
  const double median = percentile(times, 50);
  rows.add(
      {{"walk p50", median, "s",
        at_most(work.n == 100   ? std::optional(1e-6)
                : work.n == 500 ? std::optional(2e-6)
                                : std::nullopt)},
       {"walk p99", percentile(times, 99), "s", at_most(goal_if(work.n == 500, 3 * median))},
       {"walk max", percentile(times, 100), "s"},
       {"walk p99, with what the machine disturbs", percentile(contestants[0].times, 99), "s"}});
  add_truth(rows, found, exact, times);
  if (!peers.empty() && peers[0].name.starts_with("Bullet")) {
    rows.add("walk p50 over Bullet's", median / percentile(fastest(contestants[1], n), 50), "",
             at_most(goal_if(work.n == 100, 0.25)));
  } else {
    rows.note("Bullet", kLeftOut);
  }
  add_peers(rows, contestants, answers, exact);
  add_times(rows, "polytope, always", fastest(contestants.back(), n));
  rows.add("allocations", allocations(work), "", kMustBeZero);
}

void bench_distance(const Work& work, int rounds, const Rows& all) {
  std::vector<Pose> poses = work.poses;
  for (Pose& X_AB : poses) X_AB.p += kApart * normalized(X_AB.p);
  const size_t n = poses.size();
  std::vector<double> found(n);
  size_t n_steps = 0;
  ConvexPairState state;
  std::vector<Contestant> contestants{{"feature walk", [&](size_t i) {
                                         if (i == 0) state = {};
                                         const ClosestFeatures near = closest_features(
                                             HullPair(work.a, work.b, poses[i]), state);
                                         found[i] = near.distance;
                                         n_steps += static_cast<size_t>(near.n_steps);
                                       }}};
  const std::vector<HullPeer> peers = distance_peers(work.a, work.b);
  const auto answers = enter_peers(contestants, peers, poses);
  take_turns(contestants, n, kChunk, rounds);

  Rows rows = all.of("distance, " + work.name());
  add_times(rows, "feature walk", fastest(contestants[0], n));
  rows.add("steps, mean", static_cast<double>(n_steps) / static_cast<double>(n) / rounds);
  add_peers(rows, contestants, answers, found);
  if (peers.empty()) {
    rows.note("FCL", kLeftOut);
  } else {
    rows.add("feature walk p50 over FCL's", median_ratio(contestants[0], contestants[1]));
  }
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("penetration");
  for (const uint32_t n : kConvexSizes) {
    const Work work(n, options.poses);
    bench_depth(work, options.rounds, all);
    bench_distance(work, options.rounds, all);
  }
}

}  // namespace

/// Penetration depth of two convex hulls of 20 to 500 vertices at coherent poses (workload W4),
/// compared with Bullet's GJK–EPA in double, libccd and FCL, and with our own polytope for the
/// exact depth; then their distance at poses apart, compared with FCL. A time is the least of the
/// rounds for each query.
Measured bench_penetration(Command& command) {
  const auto options = std::make_shared<Options>();
  add_counts(command, {{"--poses", &options->poses, "of each pair of hulls", 100, 100000},
                       rounds_of(options->rounds, "alternations")});
  return measured(all_rows, options);
}

}  // namespace haptic
