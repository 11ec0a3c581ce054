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

/// One of kOfParts parts of equal length, of which only elements() of each are in use; the others
/// must be zero. The first and the third share a count; counts lie behind the parts.
template <size_t kWords, size_t kOfParts = 3>
struct VaryingRecord {
  static_assert(kOfParts == 2 || kOfParts == 3);
  static constexpr size_t kMost = (kWords - 2) / kOfParts;  // elements of a part
  uint64_t n = 0;
  std::array<uint64_t, kOfParts * kMost> words{};
  std::array<uint32_t, 2> counts{};

  static constexpr size_t elements(uint64_t n, size_t part) {
    return (part % 2 == 0 ? (n ^ n >> 2) * 5 : (n ^ n >> 3) * 7 + 1) % (kMost + 1);
  }
  static constexpr size_t words_of(uint64_t n) {
    size_t words = 2;
    for (size_t part = 0; part < kOfParts; ++part) words += elements(n, part);
    return words;
  }
  static VaryingRecord make(uint64_t n) {
    VaryingRecord record{n, {}, {}};
    for (size_t part = 0; part < kOfParts; ++part) {
      const size_t used = elements(n, part);
      record.counts[part % 2] = static_cast<uint32_t>(used);
      for (size_t i = part * kMost; i < part * kMost + used; ++i) {
        record.words[i] = SelfDescribing<kWords>::word(n, i);
      }
    }
    return record;
  }
  bool is_whole() const {
    const VaryingRecord expected = make(n);
    return words == expected.words && counts == expected.counts;
  }
  static constexpr std::array<RecordPart, kOfParts> parts() {
    std::array<RecordPart, kOfParts> parts{};
    for (size_t part = 0; part < kOfParts; ++part) {
      parts[part] = {8 + 8 * kMost * part, 8, kMost, 8 + sizeof(words) + 4 * (part % 2)};
    }
    return parts;
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

namespace haptic {

template <size_t kWords, size_t kOfParts>
inline constexpr auto kParts<test::VaryingRecord<kWords, kOfParts>> =
    test::VaryingRecord<kWords, kOfParts>::parts();

}  // namespace haptic
