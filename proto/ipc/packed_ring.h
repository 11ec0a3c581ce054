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

#include "proto/ipc/ring.h"
#include "proto/wire/packing.h"

namespace haptic {

/// A Ring (ring.h) of records whose length varies, packed (Packing): only the words in use are
/// copied and take room, so that many short items or few long ones stay readable.
///
/// The words of item n lie in a circular array, from `begin` on. They belong to it as long as the
/// ticket in slot n % kSlots is n + 1. Before the writer overwrites a word or a slot it sets the
/// tickets of the items that it takes them from to 0, oldest first. It stores each word with
/// release order, so a reader that copied a word of a later item finds its ticket gone. A killed
/// writer has cost the items that it took back for the next one; all from oldest() on are readable.
///
/// A reader copies as many words as the slot says, looks at the ticket again, and only then unpacks
/// them; numbers of values that do not make that length are no writer of ours. So whatever the
/// memory holds, it stays in bounds, and one that gets nothing keeps its old item. Until then the
/// words are on its stack, where only those of the item are touched.
template <typename T, uint64_t kSlots, size_t kBytes,
          template <typename> class Atomic = std::atomic>
class PackedRing {
  using Pack = Packing<T>;
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0 && kBytes % 8 == 0);
  static_assert(std::has_single_bit(kSlots) && kSlots >= 4 && kBytes >= 2 * sizeof(T));
  static_assert(Atomic<uint64_t>::is_always_lock_free && Pack::is_sound());
  // half of what RealtimeOptions::prefault_stack touches of a stack in advance
  static_assert(sizeof(T) <= 128 * 1024);

  struct alignas(32) Slot {
    Atomic<uint64_t> ticket;
    Atomic<uint64_t> begin;  // in words since the first item
    // of the item; relaxed: that of another item ends at the counts, or its ticket is gone
    Atomic<uint64_t> words;
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

  /// Writer only, a few microseconds before publish: prefetches the cache lines of the next slot
  /// and of as many words as the last item has (Ring::prefetch).
  void prefetch() const noexcept {
    const uint64_t n = count_.load(std::memory_order_relaxed);
    const uint64_t newest_words = slots_[(n - 1) % kSlots].words.load(std::memory_order_relaxed);
    __builtin_prefetch(&slots_[n % kSlots], 1);
    __builtin_prefetch(&slots_[oldest_.load(std::memory_order_relaxed) % kSlots], 1);
    const size_t at = end_.load(std::memory_order_relaxed) % kWords;
    for_each_line(at, newest_words, [](const void* line) { __builtin_prefetch(line, 1); });
  }

  /// Writer only. One copy, independent of the readers.
  void publish(const T& value) noexcept {
    const uint64_t n = count_.load(std::memory_order_relaxed);
    const uint64_t begin = end_.load(std::memory_order_relaxed);
    size_t n_words = 0;
    Pack::for_each_run(value, [&](const std::byte*, size_t length) { n_words += length / 8; });
    make_room(n, begin + n_words);
    Slot& slot = slots_[n % kSlots];
    slot.begin.store(begin, std::memory_order_release);
    slot.words.store(n_words, std::memory_order_relaxed);
    size_t at = begin % kWords;
    Pack::for_each_run(value, [&](const std::byte* from, size_t length) {
      const auto store = [&](size_t count) {
        for (size_t i = 0; i < count; ++i, from += 8) {
          uint64_t word;
          std::memcpy(&word, from, 8);
          words_[at + i].store(word, std::memory_order_release);
        }
        at = (at + count) % kWords;
      };
      const size_t before_end = std::min(length / 8, kWords - at);
      store(before_end);
      store(length / 8 - before_end);
    });
    slot.ticket.store(n + 1, std::memory_order_release);
    end_.store(begin + n_words, std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  /// A few microseconds before latest: prefetches the cache lines of the newest item, which the
  /// writer's core holds.
  void prefetch_newest() const noexcept {
    const uint64_t n = published();
    const Slot& slot = slots_[(n - 1) % kSlots];
    if (n == 0 || slot.ticket.load(std::memory_order_acquire) != n) return;
    for_each_line(slot.begin.load(std::memory_order_relaxed) % kWords,
                  slot.words.load(std::memory_order_relaxed),
                  [](const void* line) { __builtin_prefetch(line); });
  }

  /// Items published so far; the newest is published() − 1.
  uint64_t published() const noexcept { return count_.load(std::memory_order_acquire); }

  /// The oldest item that is not overwritten, with `end` published. Whatever the memory holds, a
  /// reader that goes on from there comes to an end.
  uint64_t oldest(uint64_t end) const noexcept {
    return std::clamp(oldest_.load(std::memory_order_relaxed), end - std::min(end, kSlots), end);
  }

  /// Item n; false if not yet published or already overwritten.
  bool read(uint64_t n, T& out, Take take = Take::kAll) const noexcept {
    const Slot& slot = slots_[n % kSlots];
    if (slot.ticket.load(std::memory_order_acquire) != n + 1) return false;
    const size_t at = slot.begin.load(std::memory_order_acquire) % kWords;
    const uint64_t n_words = slot.words.load(std::memory_order_relaxed);
    if (n_words < Pack::kLeastWords || n_words > Pack::kWords) return false;
    const size_t n_copied = take == Take::kAll ? n_words : Pack::kFixedBytes / 8;
    std::array<uint64_t, Pack::kWords> words;
    const size_t before_end = std::min<size_t>(n_copied, kWords - at);
    for (size_t i = 0; i < before_end; ++i) {
      words[i] = words_[at + i].load(std::memory_order_acquire);
    }
    for (size_t i = before_end; i < n_copied; ++i) {
      words[i] = words_[i - before_end].load(std::memory_order_acquire);
    }
    if (slot.ticket.load(std::memory_order_relaxed) != n + 1) return false;
    const auto* packed = reinterpret_cast<const std::byte*>(words.data());
    if (take == Take::kAll) return Pack::unpack(packed, n_words, out);
    Pack::unpack_fields(packed, out);
    return true;
  }

  /// Newest item; false before the first publish, or if overwritten during the copy.
  bool latest(T& out) const noexcept {
    const uint64_t n = published();
    return n > 0 && read(n - 1, out);
  }

 private:
  static constexpr size_t around(size_t place) { return place < kWords ? place : place - kWords; }

  /// Calls look(address) for a word in each cache line of an item that begins there.
  template <typename Look>
  void for_each_line(size_t at, uint64_t n_words, Look look) const noexcept {
    const size_t most = std::min<uint64_t>(n_words, Pack::kWords);
    for (size_t i = 0; i < most; i += 8) look(&words_[around(at + i)]);
    if (most > 0) look(&words_[around(at + most - 1)]);
  }

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
