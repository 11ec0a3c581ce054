// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "proto/ipc/ring.h"
#include "proto/ipc/segment.h"
#include "proto/math/assert.h"

/// How a reader follows a ring from one generation of its writer to the next.
namespace haptic {

namespace detail {

/// One generation of a segment in the list a reader follows.
struct Generation {
  std::unique_ptr<SegmentMapping> mapping;  // null: before the first generation
  uint64_t serial = 0;                      // position in the list
  size_t touched = 0;                       // bytes whose pages the attach thread has read once
  std::atomic<Generation*> next{nullptr};   // set once, by the attach thread
};

/// Position of a reader; the attach thread frees only generations before all readers.
struct ReaderMark {
  std::atomic<uint64_t> serial{0};
};

}  // namespace detail

/// A reader's path through the generations of a segment. Never locks, allocates, frees or enters
/// the kernel: one atomic load shows whether there is a newer generation.
template <typename Channels>
class Source {
 public:
  Source(detail::Generation* first, detail::ReaderMark* mark) : at_(first), mark_(mark) {}

  /// The rings being read; null before the first segment. Advances to the first generation by
  /// itself, later only by advance().
  const Channels* channels() noexcept {
    if (at_->mapping == nullptr) advance();
    return at_->mapping != nullptr ? &at_->mapping->template channels<Channels>() : nullptr;
  }

  /// True if the writer was replaced, so that the present rings are final.
  bool has_newer() const noexcept { return at_->next.load(std::memory_order_acquire) != nullptr; }

  /// Moves to the next generation; the one before may then be unmapped. False: there is none.
  bool advance() noexcept {
    HAPTIC_ASSERT(at_ != nullptr && mark_ != nullptr);
    detail::Generation* next = at_->next.load(std::memory_order_acquire);
    if (next == nullptr) return false;
    at_ = next;
    mark_->serial.store(next->serial, std::memory_order_release);
    return true;
  }

  /// Generation of the rings being read; 0: none yet.
  uint64_t generation() const noexcept {
    return at_->mapping != nullptr ? at_->mapping->generation() : 0;
  }

  /// Heartbeat, state and rights of the writer; null before the first segment.
  const SegmentHeader* header() const noexcept {
    return at_->mapping != nullptr ? &at_->mapping->header() : nullptr;
  }

 private:
  detail::Generation* at_;
  detail::ReaderMark* mark_;
};

/// Where a reader starts in the segment it finds first.
enum class Start {
  kNewest,  // only what is published from now on
  kOldest,  // what the ring holds, less an eighth that the writer may soon overwrite
};

/// Next item of a ring whose writer is gone. Counts exactly what cannot be read: overwritten items,
/// and those that a killed writer was about to overwrite.
template <typename RingType>
bool read_final(const RingType& ring, Cursor& cursor, typename RingType::Item& out,
                Take take = Take::kAll) noexcept {
  const uint64_t end = ring.published(), from = std::max(cursor.next, ring.oldest(end));
  cursor.lost += from - cursor.next;
  cursor.next = from;
  while (cursor.next < end) {
    if (ring.read(cursor.next++, out, take)) return true;
    ++cursor.lost;
  }
  return false;
}

template <auto kMember>
class RingSource;

/// One ring of a segment, read across restarts of its writer: what a dead writer published is read
/// before its successor's first item, and every item not delivered is counted. For one reader
/// thread; same guarantees as Source. Use: RingSource<&ServoChannels::frames>.
template <typename Channels, typename RingType, RingType Channels::*kMember>
class RingSource<kMember> {
 public:
  using Item = typename RingType::Item;

  RingSource(Source<Channels> source, Start start) : source_(source), start_(start) {}

  /// Next item in order; false: nothing new.
  bool next(Item& out, Take take = Take::kAll) noexcept {
    for (;;) {
      if (!find_ring()) return false;
      // asked before reading: what was published by then is final
      const bool ended = source_.has_newer();
      if (ended ? read_final(*ring_, cursor_, out, take) : read_next(*ring_, cursor_, out, take)) {
        item_generation_ = generation();
        return true;
      }
      if (!ended) return false;
      leave_ring();
    }
  }

  /// Newest item of the newest writer that has published one; false: nothing newer than the last
  /// one delivered. Items passed over do not count as lost.
  bool latest(Item& out) noexcept {
    bool found = false;
    while (find_ring()) {
      const bool ended = source_.has_newer();
      if (read_newest(out, ended)) {
        item_generation_ = generation();
        found = true;
      }
      if (!ended) break;
      leave_ring();
    }
    return found;
  }

  /// A few microseconds before latest(), which then finds the newest item in the cache.
  void prefetch_newest() const noexcept {
    if (ring_ != nullptr) ring_->prefetch_newest();
  }

  /// Items published since the start that next() could not deliver.
  uint64_t lost() const noexcept { return lost_ + cursor_.lost; }
  /// Generation of the writer being read; 0: none yet.
  uint64_t generation() const noexcept { return source_.generation(); }
  /// Generation of the writer of the last delivered item; 0: none yet.
  uint64_t item_generation() const noexcept { return item_generation_; }
  const SegmentHeader* header() const noexcept { return source_.header(); }

 private:
  bool find_ring() noexcept {
    if (ring_ != nullptr) return true;
    const Channels* channels = source_.channels();
    if (channels == nullptr) return false;
    ring_ = &(channels->*kMember);
    cursor_ = {};
    if (is_first_) cursor_.next = first_item();
    is_first_ = false;
    return true;
  }

  void leave_ring() noexcept {
    HAPTIC_ASSERT(ring_ != nullptr);
    lost_ += cursor_.lost;
    cursor_ = {};
    ring_ = nullptr;
    source_.advance();
  }

  uint64_t first_item() const noexcept {
    constexpr uint64_t kReach = RingType::kCapacity - RingType::kCapacity / 8;
    const uint64_t end = ring_->published(), oldest = ring_->oldest(end);
    if (start_ == Start::kNewest) return end;
    // a ring of short and long items may hold fewer than its slots
    const uint64_t safe = oldest > 0 ? oldest + (end - oldest) / 8 : 0;
    return std::max(end - std::min(end, kReach), safe);
  }

  bool read_newest(Item& out, bool ended) noexcept {
    HAPTIC_ASSERT(ring_ != nullptr);
    // the second attempt is needed only if the writer overran the ring during the copy
    for (int attempt = 0; attempt < 2; ++attempt) {
      const uint64_t end = ring_->published();
      if (end <= cursor_.next) return false;
      if (ring_->read(end - 1, out)) {
        cursor_.next = end;
        return true;
      }
      if (ended) break;
    }
    return false;
  }

  Source<Channels> source_;
  Start start_;
  const RingType* ring_ = nullptr;
  Cursor cursor_;
  uint64_t lost_ = 0;
  uint64_t item_generation_ = 0;
  bool is_first_ = true;
};

}  // namespace haptic
