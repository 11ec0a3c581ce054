// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <tuple>

#include "proto/ipc/segment.h"

namespace haptic {
namespace test {

/// A segment with one ring of any type, so that broken and sound rings are tested alike.
template <typename RingType>
struct TortureChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "torture";
  RingType records;
  using Rings = std::tuple<RingType>;
};

/// Findings of reader processes; each adds to its own.
struct ReaderFindings {
  std::atomic<uint64_t> reads;       // items delivered and checked word by word
  std::atomic<uint64_t> torn;        // mixed, or with the number of another
  std::atomic<uint64_t> disorder;    // not after the previous one
  std::atomic<uint64_t> vanished;    // announced, not overwritten, but not readable
  std::atomic<uint64_t> miscounted;  // delivered and lost do not add up to published
  std::atomic<uint64_t> lost;
};

/// Counters of a process, handed over now and then, so that a killed reader's findings are kept.
struct ReaderTally {
  uint64_t reads = 0, torn = 0, disorder = 0, vanished = 0;

  void hand_over(ReaderFindings& to) {
    to.reads += reads;
    to.torn += torn;
    to.disorder += disorder;
    to.vanished += vanished;
    *this = {};
  }
};

}  // namespace test

}  // namespace haptic
