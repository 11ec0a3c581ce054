// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "proto/ipc/ring.h"

namespace haptic::test {

/// The step left out of a ring, or the weakened memory order.
enum class Defect {
  kNone,
  // steps
  kNoRecheck,         // the reader does not check the ticket again after the copy
  kOddTicketDropped,  // the writer does not mark the slot while it overwrites it
  kHeadFirst,         // the count is incremented before the payload is written
  // memory orders, each weakened to relaxed; x86 masks all of these, the memory model does not
  kRelaxedHead,
  kRelaxedWords,
  kRelaxedTicket,
  kRelaxedCountLoad,
  kRelaxedFirstLook,
  kRelaxedWordLoads,
};

/// proto/ipc/ring.h with one defect that the tests of the ring must catch. With kNone it equals the
/// ring, which shows that a test catches the defect and not the copy.
template <typename T, uint64_t kSlots, Defect kDefect,
          template <typename> class Atomic = std::atomic>
class BrokenRing {
  static constexpr size_t kWords = sizeof(T) / 8;
  using Words = std::array<uint64_t, kWords>;

  static constexpr std::memory_order release_without(Defect defect) {
    return kDefect == defect ? std::memory_order_relaxed : std::memory_order_release;
  }
  static constexpr std::memory_order acquire_without(Defect defect) {
    return kDefect == defect ? std::memory_order_relaxed : std::memory_order_acquire;
  }

  struct alignas(64) Slot {
    Atomic<uint64_t> ticket;
    std::array<Atomic<uint64_t>, kWords> words;
  };
  alignas(128) Atomic<uint64_t> count_{0};
  alignas(128) std::array<Slot, kSlots> slots_{};

 public:
  using Item = T;
  static constexpr uint64_t kCapacity = kSlots;

  void publish(const T& value) noexcept {
    const uint64_t n = count_.load(std::memory_order_relaxed);
    const Words w = std::bit_cast<Words>(value);
    Slot& slot = slots_[n % kSlots];
    if (kDefect == Defect::kHeadFirst) count_.store(n + 1, std::memory_order_release);
    if (kDefect != Defect::kOddTicketDropped) {
      slot.ticket.store(2 * n + 1, std::memory_order_relaxed);
    }
    for (size_t i = 0; i < kWords; ++i) {
      slot.words[i].store(w[i], release_without(Defect::kRelaxedWords));
    }
    slot.ticket.store(2 * n + 2, release_without(Defect::kRelaxedTicket));
    if (kDefect != Defect::kHeadFirst) {
      count_.store(n + 1, release_without(Defect::kRelaxedHead));
    }
  }

  uint64_t published() const noexcept {
    return count_.load(acquire_without(Defect::kRelaxedCountLoad));
  }

  static uint64_t oldest(uint64_t end) noexcept { return end - std::min(end, kSlots); }

  bool read(uint64_t n, T& out, Take = Take::kAll) const noexcept {
    const Slot& slot = slots_[n % kSlots];
    if (slot.ticket.load(acquire_without(Defect::kRelaxedFirstLook)) != 2 * n + 2) return false;
    Words w;
    for (size_t i = 0; i < kWords; ++i) {
      w[i] = slot.words[i].load(acquire_without(Defect::kRelaxedWordLoads));
    }
    if (kDefect != Defect::kNoRecheck && slot.ticket.load(std::memory_order_relaxed) != 2 * n + 2) {
      return false;
    }
    out = std::bit_cast<T>(w);
    return true;
  }

  bool latest(T& out) const noexcept {
    const uint64_t n = published();
    return n > 0 && read(n - 1, out);
  }
};

}  // namespace haptic::test
