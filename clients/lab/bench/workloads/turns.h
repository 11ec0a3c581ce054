// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/lab/support/median.h"
#include "clients/report/report.h"

namespace haptic {

/// Note of a peer that this build lacks.
inline constexpr const char* kLeftOut = "LEFT OUT: install with ./run bench";

/// One of several contestants that answer the same queries.
struct Contestant {
  std::string name;
  std::function<void(size_t)> query;  // answers query i
  std::vector<double> times = {};     // of each query, all rounds [s]
  std::vector<double> chunks = {};    // sums over chunks, in step with the others' [s]
};

/// Lets the contestants take turns at chunks of the n queries, in an order shuffled for each chunk,
/// so that neither a busy machine nor the cache contents favour one. Each query is timed by itself,
/// on this clock; the cost of reading it is subtracted.
void take_turns(std::vector<Contestant>& contestants, size_t n, size_t chunk, int rounds,
                clockid_t clock = CLOCK_MONOTONIC);

/// Median over the chunks of a's time divided by b's.
double median_ratio(const Contestant& a, const Contestant& b);

/// The fastest round of each of n queries: the rest is due to the machine.
std::vector<double> fastest(const Contestant& contestant, size_t n);

/// The mean; 0 of none.
double mean_of(const std::vector<double>& values);

/// Rows "<name> p50<after>" and p99 of times beside those of a peer.
void add_beside(Rows& rows, const std::string& name, const std::vector<double>& times,
                const std::string& peer, const std::vector<double>& peer_times,
                const std::string& after = "");

/// Rows "<name> p50", p99, which may have a goal, and max.
void add_times(Rows& rows, const std::string& name, const std::vector<double>& times,
               std::optional<double> goal_p99 = {});

}  // namespace haptic
