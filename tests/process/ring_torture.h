// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>

#include "proto/ipc/segment.h"

namespace haptic {
namespace test {

/// A segment with one ring of any type, so that a broken one goes the same way as a sound one.
template <typename RingType>
struct TortureChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "torture";
  RingType records;
};

/// What reader processes found; each adds to its own.
struct ReaderFindings {
  std::atomic<uint64_t> reads;       // items delivered and looked at word by word
  std::atomic<uint64_t> torn;        // mixed, or under another's number
  std::atomic<uint64_t> disorder;    // not after the one before
  std::atomic<uint64_t> vanished;    // announced, not overwritten, and yet not there
  std::atomic<uint64_t> miscounted;  // delivered and lost do not add up to published
  std::atomic<uint64_t> lost;
};

/// Counts as one process goes, handed over now and then: a killed reader's findings are kept.
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

/// 1, or less where a sanitizer makes every access slow.
double sanitizer_scale();

}  // namespace test

template <typename RingType>
struct ChannelTable<test::TortureChannels<RingType>> {
  static constexpr std::array value{
      describe_ring<RingType>("records", offsetof(test::TortureChannels<RingType>, records))};
};

}  // namespace haptic
