// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <type_traits>

namespace haptic {

/// A reader copies all of an item that is in use, or only the fields before its lists
/// (packed_ring.h), which are then empty.
enum class Take { kAll, kFields };

/// The channel of the project: single writer, many readers, overwriting, wait-free.
///
/// Item n lives in slot n % kSlots under a ticket: 2n+1 while it is being written, 2n+2 once
/// complete. A reader copies the words between two reads of the ticket, so it needs no write access
/// and may be stopped, killed or late at no cost to the writer. A writer killed during a copy
/// leaves an odd ticket, which costs at most the oldest item of a full ring: the newest kSlots − 1
/// counted items stay readable. All-zero memory is an empty ring; it holds no pointers. Seqlock
/// after Boehm 2012. Atomic is std::atomic except in the test that tries every outcome the memory
/// model allows.
template <typename T, uint64_t kSlots, template <typename> class Atomic = std::atomic>
class Ring {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  static_assert(std::has_single_bit(kSlots) && kSlots >= 4);
  static_assert(Atomic<uint64_t>::is_always_lock_free);
  static constexpr size_t kWords = sizeof(T) / 8;

  struct alignas(64) Slot {
    Atomic<uint64_t> ticket;
    std::array<Atomic<uint64_t>, kWords> words;
  };
  // own pair of cache lines: readers poll it while the writer fills slots
  alignas(128) Atomic<uint64_t> count_{0};
  alignas(128) std::array<Slot, kSlots> slots_{};

 public:
  using Item = T;
  static constexpr uint64_t kCapacity = kSlots;

  /// Writer only, a few microseconds before publish: prefetches the cache lines of the next slot.
  /// At 1 kHz they have been evicted, and the misses would be most of the cost of publishing.
  void prefetch() const noexcept {
    const Slot& slot = slots_[count_.load(std::memory_order_relaxed) % kSlots];
    const auto* bytes = reinterpret_cast<const std::byte*>(&slot);
    for (size_t i = 0; i < sizeof(Slot); i += 64) __builtin_prefetch(bytes + i, 1);
  }

  /// Writer only. One copy, independent of the readers.
  void publish(const T& value) noexcept {
    const uint64_t n = count_.load(std::memory_order_relaxed);
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    Slot& slot = slots_[n % kSlots];
    slot.ticket.store(2 * n + 1, std::memory_order_relaxed);
    // release on each word: none becomes visible before the odd ticket (a plain mov on x86)
    for (size_t i = 0; i < kWords; ++i) {
      uint64_t word;
      std::memcpy(&word, bytes + 8 * i, 8);
      slot.words[i].store(word, std::memory_order_release);
    }
    slot.ticket.store(2 * n + 2, std::memory_order_release);
    count_.store(n + 1, std::memory_order_release);
  }

  /// Items published so far; the newest is published() − 1.
  uint64_t published() const noexcept { return count_.load(std::memory_order_acquire); }

  /// The oldest item that is not overwritten, with `end` published.
  static uint64_t oldest(uint64_t end) noexcept { return end - std::min(end, kSlots); }

  /// Item n; false if not yet published or already overwritten.
  bool read(uint64_t n, T& out, Take = Take::kAll) const noexcept {
    const Slot& slot = slots_[n % kSlots];
    if (slot.ticket.load(std::memory_order_acquire) != 2 * n + 2) return false;
    // copied first: a reader that gets nothing keeps its old item
    std::array<uint64_t, kWords> w;
    for (size_t i = 0; i < kWords; ++i) w[i] = slot.words[i].load(std::memory_order_acquire);
    if (slot.ticket.load(std::memory_order_relaxed) != 2 * n + 2) return false;
    std::memcpy(static_cast<void*>(&out), w.data(), sizeof out);
    return true;
  }

  /// Newest item; false before the first publish, or if overwritten during the copy.
  bool latest(T& out) const noexcept {
    const uint64_t n = published();
    return n > 0 && read(n - 1, out);
  }
};

/// Position of a reader in a ring, and the number of items it missed.
struct Cursor {
  uint64_t next = 0;
  uint64_t lost = 0;
};

/// Next unread item in order. A reader that was overrun jumps half way to the writer, so as not to
/// be overrun again at once, and counts exactly what it skipped.
template <typename RingType>
bool read_next(const RingType& ring, Cursor& cursor, typename RingType::Item& out,
               Take take = Take::kAll) noexcept {
  for (uint64_t end = ring.published(); cursor.next < end; end = ring.published()) {
    if (ring.read(cursor.next, out, take)) {
      ++cursor.next;
      return true;
    }
    const uint64_t target = std::max(cursor.next + 1, std::midpoint(ring.oldest(end), end));
    cursor.lost += target - cursor.next;
    cursor.next = target;
  }
  return false;
}

}  // namespace haptic
