// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz_random.h"

namespace haptic::test {

/// Damages inputs as programs, disks and people do: flipped bits, cuts, repeats, numbers at the
/// edge of their type, and words of a format in the wrong place.
class Damage {
 public:
  explicit Damage(std::vector<std::string> words) : words_(std::move(words)) {}

  /// The text after one to eight changes, at most `longest` bytes of it.
  std::string apply(std::string text, FuzzRandom& random, size_t longest = 64 << 10) const {
    for (size_t left = 1 + random.below(8); left > 0; --left) change(text, random);
    if (text.size() > longest) text.resize(longest);
    return text;
  }

 private:
  void change(std::string& text, FuzzRandom& random) const {
    const size_t at = random.below(text.size() + 1);
    const size_t some = random.below(std::min<size_t>(text.size() - at, 64) + 1);
    switch (random.below(8)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << random.below(8)));
        break;
      case 1:
        if (at < text.size()) text[at] = static_cast<char>(random.below(256));
        break;
      case 2:
        text.erase(at, some);
        break;
      case 3:
        text.insert(random.below(text.size() + 1), text.substr(at, some));
        break;
      case 4:
        text.replace(at, some, words_.empty() ? "" : random.pick(words_));
        break;
      case 5:
        put_number(text, at, random);
        break;
      case 6:
        if (random.below(4) == 0) text.resize(at);
        break;
      default:
        text.insert(at, random.below(200), static_cast<char>(random.below(256)));
    }
  }

  /// Overwrites a place with a number of 1, 2, 4 or 8 bytes near an edge of its type.
  static void put_number(std::string& text, size_t at, FuzzRandom& random) {
    const size_t size = size_t{1} << random.below(4);
    uint64_t value = random.below(2) == 0 ? 0 : ~uint64_t{0};
    value ^= uint64_t{1} << random.below(64);
    value += random.below(3);
    if (at + size > text.size()) return;
    text.replace(at, size, reinterpret_cast<const char*>(&value), size);
  }

  std::vector<std::string> words_;
};

}  // namespace haptic::test
