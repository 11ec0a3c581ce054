// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/turns.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "clients/lab/support/thread_cpu.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

/// Duration of an empty measurement [ns].
double clock_cost(clockid_t clock) {
  std::vector<double> pairs(10001);
  for (double& pair : pairs) pair = static_cast<double>(ns_on(clock, [] {}));
  return median(pairs);
}

}  // namespace

void take_turns(std::vector<Contestant>& contestants, size_t n, size_t chunk, int rounds,
                clockid_t clock) {
  const double cost = clock_cost(clock);
  std::mt19937 random(1);
  std::vector<size_t> order(contestants.size());
  std::iota(order.begin(), order.end(), size_t{0});
  Progress progress("measuring", static_cast<double>(rounds) * static_cast<double>(n));
  for (int round = 0; round < rounds; ++round) {
    for (size_t begin = 0; begin < n; begin += chunk) {
      progress.at(static_cast<double>(round) * static_cast<double>(n) + static_cast<double>(begin));
      std::shuffle(order.begin(), order.end(), random);
      for (const size_t k : order) {
        Contestant& contestant = contestants[k];
        double sum = 0;
        for (size_t i = begin; i < std::min(n, begin + chunk); ++i) {
          const auto ns = static_cast<double>(ns_on(clock, [&] { contestant.query(i); }));
          contestant.times.push_back(1e-9 * std::max(ns - cost, 0.0));
          sum += contestant.times.back();
        }
        contestant.chunks.push_back(sum);
      }
    }
  }
}

double median_ratio(const Contestant& a, const Contestant& b) {
  std::vector<double> ratios(a.chunks.size());
  std::transform(a.chunks.begin(), a.chunks.end(), b.chunks.begin(), ratios.begin(),
                 [](double x, double y) { return x / y; });
  return median(ratios);
}

std::vector<double> fastest(const Contestant& contestant, size_t n) {
  const std::vector<double>& times = contestant.times;
  std::vector<double> best(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(n));
  for (size_t k = n; k < times.size(); ++k) best[k % n] = std::min(best[k % n], times[k]);
  return best;
}

double mean_of(const std::vector<double>& values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return sum / static_cast<double>(std::max<size_t>(values.size(), 1));
}

void add_beside(Rows& rows, const std::string& name, const std::vector<double>& times,
                const std::string& peer, const std::vector<double>& peer_times,
                const std::string& after) {
  for (const int q : {50, 99}) {
    rows.add_beside(name + " p" + std::to_string(q) + after, percentile(times, q), "s", peer,
                    percentile(peer_times, q));
  }
}

void add_times(Rows& rows, const std::string& name, const std::vector<double>& times,
               std::optional<double> goal_p99) {
  rows.add({{name + " p50", percentile(times, 50), "s"},
            {name + " p99", percentile(times, 99), "s", at_most(goal_p99)},
            {name + " max", percentile(times, 100), "s"}});
}

}  // namespace haptic
