// SPDX-License-Identifier: Apache-2.0
#include "clients/library/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic {
namespace {

constexpr int kBits = 7;                                    // 2⁷ buckets per octave
constexpr uint64_t kPerOctave = uint64_t{1} << kBits;       // buckets
constexpr size_t kBuckets = (63 - kBits + 1) * kPerOctave;  // up to the largest int64_t

/// Values below 2⁸ have a bucket each; an octave above is split by the 7 bits after its leading
/// one.
size_t bucket_of(uint64_t value) {
  const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - kBits - 1);
  return static_cast<size_t>(static_cast<uint64_t>(shift) * kPerOctave + (value >> shift));
}

/// Largest value of a bucket.
uint64_t upper_end(size_t bucket) {
  const uint64_t octave = bucket / kPerOctave;
  if (octave < 2) return bucket;
  const uint64_t shift = octave - 1;
  const uint64_t top = bucket - shift * kPerOctave;
  return ((top + 1) << shift) - 1;
}

}  // namespace

Histogram::Histogram() : buckets_(kBuckets) {}

void Histogram::add(int64_t value_ns) {
  const int64_t value = std::max<int64_t>(0, value_ns);
  ++buckets_[bucket_of(static_cast<uint64_t>(value))];
  ++count_;
  max_ = std::max(max_, value);
}

void Histogram::merge(const Histogram& other) {
  for (size_t i = 0; i < kBuckets; ++i) buckets_[i] += other.buckets_[i];
  count_ += other.count_;
  max_ = std::max(max_, other.max_);
}

int64_t Histogram::percentile(double percent) const {
  const double share = std::clamp(percent, 0.0, 100.0) / 100;
  // minus a rounding margin: 99.9 % of 1000 is rank 999 although 0.999 is not exact in binary
  const double rank = std::ceil(share * static_cast<double>(count_) - 1e-9);
  const uint64_t wanted = std::max<uint64_t>(1, static_cast<uint64_t>(std::max(rank, 0.0)));
  uint64_t seen = 0;
  for (size_t i = 0; i < kBuckets; ++i) {
    seen += buckets_[i];
    if (seen >= wanted) return std::min(static_cast<int64_t>(upper_end(i)), max_);
  }
  return max_;
}

}  // namespace haptic
