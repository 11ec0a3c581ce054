// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace haptic {

/// Counts of durations [ns] in log-linear buckets: exact below 256, then 128 buckets per octave. A
/// percentile is never below the true one and at most 1/128 above it; maximum and count are exact.
/// 59 kB, allocated once; adding takes constant time.
class Histogram {
 public:
  Histogram();

  /// Negative durations count as zero.
  void add(int64_t value_ns);
  void merge(const Histogram& other);

  uint64_t count() const { return count_; }
  int64_t max() const { return max_; }

  /// Nearest rank: the smallest value that at least `percent` % of the values do not exceed,
  /// rounded up to the end of its bucket; 0 when empty.
  int64_t percentile(double percent) const;

 private:
  std::vector<uint64_t> buckets_;
  uint64_t count_ = 0;
  int64_t max_ = 0;
};

}  // namespace haptic
