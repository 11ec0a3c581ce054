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

/// A record of kOfParts parts of the same length, of which elements() of each are in use.
template <size_t kWords, size_t kOfParts = 3>
struct VaryingRecord {
  static constexpr size_t kMost = (kWords - 1) / kOfParts - 1;  // elements of a part
  using Part = Packed<uint64_t, kMost>;
  uint64_t n = 0;
  std::array<Part, kOfParts> parts{};

  static constexpr size_t elements(uint64_t n, size_t part) {
    return ((n ^ n >> (2 + part)) * (5 + 2 * part) + part) % (kMost + 1);
  }
  static constexpr size_t words_of(uint64_t n) {
    size_t words = 1 + kOfParts;
    for (size_t part = 0; part < kOfParts; ++part) words += elements(n, part);
    return words;
  }
  static constexpr uint64_t word(uint64_t n, size_t part, size_t i) {
    return SelfDescribing<kWords>::word(n, part * kMost + i);
  }
  static VaryingRecord make(uint64_t n) {
    VaryingRecord record;
    record.n = n;
    for (size_t part = 0; part < kOfParts; ++part) {
      for (size_t i = 0; i < elements(n, part); ++i) record.parts[part].push_back(word(n, part, i));
    }
    return record;
  }
  bool is_whole() const {
    for (size_t part = 0; part < kOfParts; ++part) {
      if (parts[part].size() != elements(n, part)) return false;
      for (size_t i = 0; i < parts[part].size(); ++i) {
        if (parts[part][i] != word(n, part, i)) return false;
      }
    }
    return true;
  }
  static constexpr std::array<RecordPart, kOfParts> table() {
    std::array<RecordPart, kOfParts> rows{};
    for (size_t part = 0; part < kOfParts; ++part) rows[part] = {8 + sizeof(Part) * part, 8, kMost};
    return rows;
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
    test::VaryingRecord<kWords, kOfParts>::table();

}  // namespace haptic
