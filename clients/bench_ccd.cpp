// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench_ccd.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "clients/bench_ccd_peers.h"
#include "clients/bench_pair_peers.h"
#include "clients/bench_pair_workload.h"
#include "clients/bench_turns.h"
#include "clients/redon_intervals.h"
#include "contact/query/swept_mesh.h"

namespace haptic {
namespace {

constexpr const char* kLeftOut = "LEFT OUT: install with ./run bench";
constexpr SweptPairOptions kCapped{1e-6, 500}, kUncapped{1e-6, 1'000'000}, kAdvanced{1e-6, 0};
constexpr double kShortest = 1e-6;  // stretch of Redon's method
constexpr uint32_t kBisections = 20'000;
// of 7,279 queries Tight-Inclusion at 1e-6 has 222 false alarms, plain bisection 274
constexpr double kFalseAlarmGoal = 250.0 / 7279;
constexpr double kMedianGoal = 100e-9, kWorstGoal = 100e-6;
constexpr double kImpactMedianGoal = 0.3e-3, kImpactP99Goal = 1e-3;

struct Tally {
  double meets = 0, missed = 0, false_alarms = 0;

  void add(bool truth, bool answer) {
    meets += truth;
    missed += truth && !answer;
    false_alarms += !truth && answer;
  }
};

double longest(const Contestant& c) {
  return *std::max_element(c.times.begin(), c.times.end());
}

/// The fastest of the rounds of each query: what the machine adds is not the query's.
std::vector<double> fastest(const Contestant& c, size_t n) {
  std::vector<double> best(c.times.begin(), c.times.begin() + static_cast<std::ptrdiff_t>(n));
  for (size_t k = n; k < c.times.size(); ++k) best[k % n] = std::min(best[k % n], c.times[k]);
  return best;
}

void add_times(Rows& rows, const Contestant& c, size_t n) {
  const std::vector<double> best = fastest(c, n);
  rows.add(c.name + ": p50", percentile(best, 50), "s");
  rows.add(c.name + ": p99", percentile(best, 99), "s");
  rows.add(c.name + ": max", percentile(best, 100), "s");
}

void bench_truth(Rows& rows, const BenchCcdOptions& options) {
  const std::vector<CcdFile> files = read_ccd_queries(options.queries);
  if (files.empty()) {
    rows.note("ground truth", "LEFT OUT: no queries in '" + options.queries +
                                  "'; give their folder with --queries");
    return;
  }
  Tally capped_all, uncapped_all, advanced_all, intervals_all, fcl_all, newton_all;
  std::vector<CcdQuery> all;
  for (const CcdFile& file : files) {
    Tally uncapped;
    for (const CcdQuery& query : file.queries) {
      uncapped.add(query.meets, meeting_of(query, kUncapped).has_value());
      uncapped_all.add(query.meets, meeting_of(query, kUncapped).has_value());
      capped_all.add(query.meets, meeting_of(query, kCapped).has_value());
      advanced_all.add(query.meets, meeting_of(query, kAdvanced).has_value());
      intervals_all.add(query.meets,
                        meeting_by_intervals(query, kShortest, kBisections).has_value());
      fcl_all.add(query.meets, meeting_by_fcl(query, false).has_value());
      newton_all.add(query.meets, meeting_by_fcl(query, true).has_value());
      all.push_back(query);
    }
    rows.note(file.scene, std::to_string(file.queries.size()) + " queries, " +
                              std::to_string(static_cast<int>(uncapped.meets)) + " meet");
    rows.add(file.scene + ": missed", uncapped.missed, "", 0, uncapped.missed == 0);
    rows.add(file.scene + ": false alarms", uncapped.false_alarms, "");
  }
  const auto n = static_cast<double>(all.size());
  const auto add = [&](const std::string& name, const Tally& tally, bool judged) {
    rows.add_if(judged, name + ": missed", tally.missed, "", 0, tally.missed == 0);
    rows.add(name + ": false alarms", tally.false_alarms, "");
  };
  add("uncapped", uncapped_all, true);
  rows.add("uncapped: false alarms in parts", uncapped_all.false_alarms / n, "", kFalseAlarmGoal,
           uncapped_all.false_alarms / n <= kFalseAlarmGoal);
  add("500 boxes at most", capped_all, true);
  add("advanced only", advanced_all, true);
  add("intervals in time", intervals_all, false);
  if (has_fcl_features()) {
    add("FCL, bisection", fcl_all, false);
    add("FCL, Newton", newton_all, false);
  }
  std::vector<Contestant> contestants{
      {"500 boxes at most", [&](size_t i) { meeting_of(all[i], kCapped); }},
      {"advanced only", [&](size_t i) { meeting_of(all[i], kAdvanced); }},
      {"intervals in time",
       [&](size_t i) { meeting_by_intervals(all[i], kShortest, kBisections); }}};
  if (has_fcl_features()) {
    contestants.push_back({"FCL, bisection", [&](size_t i) { meeting_by_fcl(all[i], false); }});
  }
  take_turns(contestants, all.size(), 100, options.rounds);
  for (const Contestant& c : contestants) add_times(rows, c, all.size());
  const double worst = percentile(fastest(contestants[0], all.size()), 100);
  rows.add("500 boxes at most: longest query", worst, "s", kWorstGoal, worst <= kWorstGoal);
}

void bench_hand_scale(Rows& rows, const BenchCcdOptions& options) {
  const std::vector<CcdQuery> queries = hand_scale_queries(options.hand_scale);
  std::vector<char> own(queries.size()), intervals(queries.size()), fcl(queries.size());
  std::vector<Contestant> contestants{
      {"own", [&](size_t i) { own[i] = meeting_of(queries[i], kCapped).has_value(); }},
      {"advanced only", [&](size_t i) { meeting_of(queries[i], kAdvanced); }},
      {"intervals in time", [&](size_t i) {
         intervals[i] = meeting_by_intervals(queries[i], kShortest, kBisections).has_value();
       }}};
  if (has_fcl_features()) {
    contestants.push_back({"FCL, bisection", [&](size_t i) {
                             fcl[i] = meeting_by_fcl(queries[i], false).has_value();
                           }});
    contestants.push_back({"FCL, Newton", [&](size_t i) { meeting_by_fcl(queries[i], true); }});
  } else {
    rows.note("FCL", kLeftOut);
  }
  take_turns(contestants, queries.size(), 1000, options.rounds);
  double meet = 0, only_intervals = 0, only_fcl = 0, only_own = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    meet += own[i];
    only_own += own[i] && !intervals[i];
    only_intervals += !own[i] && intervals[i];
    only_fcl += !own[i] && fcl[i];
  }
  rows.add("meet", meet, "");
  // neither of the two ever misses: where they differ one has a false alarm
  rows.add("meet, but not by intervals in time", only_own, "");
  rows.add("meet by intervals in time alone", only_intervals, "");
  rows.add("meet by FCL alone", only_fcl, "");
  for (const Contestant& c : contestants) add_times(rows, c, queries.size());
  const double median = percentile(contestants[0].times, 50);
  rows.add("own: p50 of all rounds", median, "s", kMedianGoal, median <= kMedianGoal);
  for (size_t k = 1; k < contestants.size(); ++k) {
    rows.add("own over " + contestants[k].name, median_ratio(contestants[0], contestants[k]), "");
  }
}

struct Impact {
  double time = 1;
  bool meets = false;
};

/// By steps in which nothing can reach what FCL says is apart.
Impact advance_by_distance(PairPeer& peer, const RigidMotion& motion, double lever) {
  constexpr double kNear = 1e-6;
  const double speed = norm(motion.way_O) + motion.angle * lever;
  double t = 0;
  for (int step = 0; step < 500; ++step) {
    const double distance = peer.distance(motion.at(t));
    if (distance < kNear) return {t, true};
    t += distance / speed;
    if (t > 1) return {};
  }
  return {t, true};
}

void bench_impact(Rows& rows, const BenchCcdOptions& options) {
  const MeshShapeData object = build_shape(make_bumpy_torus(200, 100));
  const MeshShapeData tool = build_shape(make_bumpy_torus(164, 82));
  const MeshShape object_view = object.view(), tool_view = tool.view();
  const std::vector<RigidMotion> motions = torus_motions(object_view, tool_view, options.motions);
  const std::unique_ptr<PairPeer> fcl = make_fcl_peer(object_view.mesh, tool_view.mesh);
  double lever = 0;
  for (const Vec3& v : tool.mesh.vertices) lever = std::max(lever, norm(v));

  SweptMesh swept(object_view, tool_view);
  std::vector<Impact> own(motions.size()), by_fcl(motions.size());
  std::vector<Contestant> contestants{{"own", [&](size_t i) {
                                         const auto hit =
                                             swept.time_of_impact(motions[i], kAdvanced);
                                         own[i] = {hit.time, hit.meets};
                                       }}};
  if (fcl) {
    contestants.push_back({"advanced by FCL's distance", [&](size_t i) {
                             by_fcl[i] = advance_by_distance(*fcl, motions[i], lever);
                           }});
  } else {
    rows.note("FCL", kLeftOut);
  }
  take_turns(contestants, motions.size(), 10, options.rounds);

  double hits = 0, late = 0, apart = 0, differ = 0;
  for (size_t i = 0; i < motions.size(); ++i) {
    hits += own[i].meets;
    constexpr int kSamples = 50;
    for (int k = 0; k <= kSamples; ++k) {
      const Pose X_OT = motions[i].at(own[i].time * k / kSamples * (1 - 1e-12));
      if (triangle_pairs(object_view, tool_view, X_OT, {}) == 0) continue;
      ++late;
      break;
    }
    if (!fcl) continue;
    if (own[i].meets) apart = std::max(apart, fcl->distance(motions[i].at(own[i].time)));
    differ += own[i].meets != by_fcl[i].meets;
  }
  rows.add("motions", static_cast<double>(motions.size()), "");
  rows.add("of them hit", hits, "");
  rows.add("late, by exact intersection before", late, "", 0, late == 0);
  if (fcl) {
    rows.add("furthest apart at a hit, by FCL", apart, "m", kAdvanced.tolerance,
             apart <= kAdvanced.tolerance * 1.001);
    rows.add("hit for one and not for the other", differ, "");
  }
  const std::vector<double> best = fastest(contestants[0], motions.size());
  const double p50 = percentile(best, 50), p99 = percentile(best, 99);
  rows.add("own: p50", p50, "s", kImpactMedianGoal, p50 <= kImpactMedianGoal);
  rows.add("own: p99", p99, "s", kImpactP99Goal, p99 <= kImpactP99Goal);
  rows.add("own: max of all rounds", longest(contestants[0]), "s");
  if (fcl) {
    add_times(rows, contestants[1], motions.size());
    rows.add("own over FCL's distance", median_ratio(contestants[0], contestants[1]), "");
  }
}

}  // namespace

std::vector<Row> bench_ccd(const BenchCcdOptions& options) {
  Rows machine("machine"), truth("ccd, ground truth"), hand("ccd, hand scale"),
      impact("ccd, tori of 27 k and 40 k triangles");
  machine.note("machine", machine_line());
  bench_truth(truth, options);
  bench_hand_scale(hand, options);
  bench_impact(impact, options);
  for (const Rows* rows : {&truth, &hand, &impact}) machine.append(rows->rows());
  return machine.rows();
}

}  // namespace haptic
