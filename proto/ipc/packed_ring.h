// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace haptic {

/// Bytes [begin, end) of a record are not in use; `end` is the same for all records of a type.
struct UnusedBytes {
  size_t begin, end;
};

/// A Ring (ring.h) of records whose length varies: only the words in use are copied and take room,
/// so that many short items or few long ones stay readable. unused_bytes(record) says which are
/// not.
///
/// The words of item n lie in a circular array, from `begin` on. They belong to it as long as the
/// ticket in slot n % kSlots is n + 1. Before the writer overwrites a word or a slot it sets the
/// tickets of the items that it takes them from to 0, oldest first. It stores each word with
/// release order, so a reader that copied a word of a later item finds its ticket gone. A killed
/// writer has cost the items that it took back for the next one; all from oldest() on are readable.
template <typename T, uint64_t kSlots, size_t kBytes,
          template <typename> class Atomic = std::atomic>
class PackedRing {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0 && kBytes % 8 == 0);
  static_assert(std::has_single_bit(kSlots) && kSlots >= 4 && kBytes >= 2 * sizeof(T));
  static_assert(Atomic<uint64_t>::is_always_lock_free);
  static constexpr size_t kItemWords = sizeof(T) / 8;
  static constexpr size_t kFrontWords = unused_bytes(T{}).end / 8;  // at most, before the gap
  static constexpr size_t kBackWords = kItemWords - kFrontWords;

  struct alignas(32) Slot {
    Atomic<uint64_t> ticket;
    Atomic<uint64_t> begin;  // in words since the first item
    Atomic<uint64_t> front;  // words before the gap
  };
  // own pair of cache lines: readers poll them while the writer fills slots
  alignas(128) Atomic<uint64_t> count_{0};
  Atomic<uint64_t> oldest_{0};
  Atomic<uint64_t> end_{0};  // of the newest item, in words since the first
  alignas(128) std::array<Slot, kSlots> slots_{};
  alignas(128) std::array<Atomic<uint64_t>, kBytes / 8> words_{};

 public:
  using Item = T;
  static constexpr uint64_t kCapacity = kSlots;
  static constexpr uint64_t kWords = kBytes / 8;

  /// Writer only. One copy, independent of the readers.
  void publish(const T& value) noexcept {
    const uint64_t n = count_.load(std::memory_order_relaxed);
    const uint64_t begin = end_.load(std::memory_order_relaxed);
    const size_t front = unused_bytes(value).begin / 8;
    const uint64_t end = begin + front + kBackWords;
    make_room(n, end);
    Slot& slot = slots_[n % kSlots];
    slot.begin.store(begin, std::memory_order_release);
    slot.front.store(front, std::memory_order_release);
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    const size_t at = begin % kWords;
    // `gap`: words of the value left out before these
    const auto store = [&](size_t from, size_t to, size_t gap) {
      for (size_t i = from; i < to; ++i) {
        uint64_t word;
        std::memcpy(&word, bytes + 8 * (i + gap), 8);
        words_[around(at + i)].store(word, std::memory_order_release);
      }
    };
    store(0, front, 0);
    store(front, front + kBackWords, kFrontWords - front);
    slot.ticket.store(n + 1, std::memory_order_release);
    end_.store(end, std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  /// A few microseconds before latest: prefetches the cache lines of the newest item, which the
  /// writer's core holds.
  void prefetch_newest() const noexcept {
    const uint64_t n = published();
    const Slot& slot = slots_[(n - 1) % kSlots];
    if (n == 0 || slot.ticket.load(std::memory_order_acquire) != n) return;
    const size_t at = slot.begin.load(std::memory_order_relaxed) % kWords;
    const size_t n_words =
        std::min<uint64_t>(slot.front.load(std::memory_order_relaxed), kFrontWords) + kBackWords;
    for (size_t i = 0; i < n_words; i += 8) __builtin_prefetch(&words_[around(at + i)]);
  }

  /// Items published so far; the newest is published() − 1.
  uint64_t published() const noexcept { return count_.load(std::memory_order_acquire); }

  /// The oldest item that is not overwritten, with `end` published. Whatever the memory holds, a
  /// reader that goes on from there comes to an end.
  uint64_t oldest(uint64_t end) const noexcept {
    return std::clamp(oldest_.load(std::memory_order_relaxed), end - std::min(end, kSlots), end);
  }

  /// Item n; false if not yet published or already overwritten. What the item does not use is zero
  /// in an `out` that began as T{}: only what was in use before is cleared.
  bool read(uint64_t n, T& out) const noexcept {
    const Slot& slot = slots_[n % kSlots];
    if (slot.ticket.load(std::memory_order_acquire) != n + 1) return false;
    const size_t at = slot.begin.load(std::memory_order_acquire) % kWords;
    const uint64_t front = slot.front.load(std::memory_order_acquire);
    if (front > kFrontWords) return false;  // no writer of ours
    // copied first: a reader that gets nothing keeps its old item
    std::array<uint64_t, kItemWords> w;
    for (size_t i = 0; i < front + kBackWords; ++i) {
      w[i] = words_[around(at + i)].load(std::memory_order_acquire);
    }
    if (slot.ticket.load(std::memory_order_relaxed) != n + 1) return false;
    const size_t used = unused_bytes(out).begin / 8;
    auto* bytes = reinterpret_cast<std::byte*>(&out);
    std::memcpy(bytes, w.data(), 8 * front);
    if (used > front) std::memset(bytes + 8 * front, 0, 8 * (used - front));
    std::memcpy(bytes + 8 * kFrontWords, w.data() + front, 8 * kBackWords);
    return true;
  }

  /// Newest item; false before the first publish, or if overwritten during the copy.
  bool latest(T& out) const noexcept {
    const uint64_t n = published();
    return n > 0 && read(n - 1, out);
  }

 private:
  static constexpr size_t around(size_t place) { return place < kWords ? place : place - kWords; }

  /// Takes back the oldest items until slot n % kSlots and the words before `end` are free.
  void make_room(uint64_t n, uint64_t end) noexcept {
    for (uint64_t m = oldest_.load(std::memory_order_relaxed); m < n; ++m) {
      Slot& slot = slots_[m % kSlots];
      const uint64_t begin = slot.begin.load(std::memory_order_relaxed);
      if (n - m < kSlots && end - begin <= kWords) return;
      oldest_.store(m + 1, std::memory_order_relaxed);
      slot.ticket.store(0, std::memory_order_relaxed);
    }
  }
};

}  // namespace haptic
