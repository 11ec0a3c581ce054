// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace haptic {

/// One of several that answer the same queries.
struct Contestant {
  std::string name;
  std::function<void(size_t)> query;  // answers query i
  std::vector<double> times = {};     // of each query [s], all rounds
  std::vector<double> chunks = {};    // sums over chunks [s], in step with the others'
};

/// Lets them take turns at chunks of the n queries, in an order shuffled anew for each chunk, so
/// that neither a busy machine nor what another left in the caches favours one. Each query is timed
/// alone; what reading the clock takes is subtracted.
void take_turns(std::vector<Contestant>& contestants, size_t n, size_t chunk, int rounds);

/// Median over the chunks of a's time over b's.
double median_ratio(const Contestant& a, const Contestant& b);

/// The q-th percentile of single queries, q in [0, 100].
double percentile(std::vector<double> times, double q);

}  // namespace haptic
