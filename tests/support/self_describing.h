// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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
};

}  // namespace haptic::test
