// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "proto/ipc/packed_ring.h"

namespace haptic::test {

/// A record whose words all follow from its number, so that a reader can detect mixed records.
template <size_t kWords>
struct SelfDescribing {
  uint64_t n = 0;
  std::array<uint64_t, kWords - 1> words{};

  static constexpr uint64_t word(uint64_t n, size_t i) {
    return (n + 1) * 0x9e37'79b9'7f4a'7c15 + i * 0xbf58'476d'1ce4'e5b9;
  }
  static SelfDescribing make(uint64_t n) {
    SelfDescribing record{n, {}};
    for (size_t i = 0; i < record.words.size(); ++i) record.words[i] = word(n, i);
    return record;
  }
  bool is_whole() const {
    for (size_t i = 0; i < words.size(); ++i) {
      if (words[i] != word(n, i)) return false;
    }
    return true;
  }
  static constexpr size_t words_of(uint64_t) { return kWords; }
};

/// One of which only n_parts() of its parts are in use; the others must be zero.
template <size_t kWords>
struct VaryingRecord {
  uint64_t n = 0;
  std::array<uint64_t, kWords - 2> parts{};
  uint64_t last = 0;

  static constexpr size_t n_parts(uint64_t n) { return (n ^ n >> 2) * 5 % (kWords - 1); }
  static constexpr size_t words_of(uint64_t n) { return n_parts(n) + 2; }
  static VaryingRecord make(uint64_t n) {
    VaryingRecord record{n, {}, SelfDescribing<kWords>::word(n, kWords)};
    for (size_t i = 0; i < n_parts(n); ++i) record.parts[i] = SelfDescribing<kWords>::word(n, i);
    return record;
  }
  bool is_whole() const {
    const VaryingRecord expected = make(n);
    return parts == expected.parts && last == expected.last;
  }
  friend constexpr UnusedBytes unused_bytes(const VaryingRecord& record) {
    return {8 + 8 * n_parts(record.n), 8 + sizeof(parts)};
  }
};

/// Items before number `end` that stay readable while that one is written.
template <typename RingType>
uint64_t reach(uint64_t end) {
  uint64_t most_words = ~uint64_t{0};
  if constexpr (requires { RingType::kWords; }) most_words = RingType::kWords;
  uint64_t words = RingType::Item::words_of(end), items = 0;
  while (items < std::min(end, RingType::kCapacity - 1)) {
    words += RingType::Item::words_of(end - items - 1);
    if (words > most_words) break;
    ++items;
  }
  return items;
}

}  // namespace haptic::test
