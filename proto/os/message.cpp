// SPDX-License-Identifier: Apache-2.0
#include "proto/os/message.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace haptic {
namespace {

/// The first character of a text.
struct Character {
  size_t bytes = 1;
  char32_t code = 0;
  bool is_utf8 = false;
};

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

/// RFC 3629: no surrogates, no overlong forms, nothing above U+10FFFF.
Character first_character(std::string_view text) {
  const char32_t lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {1, lead, true};
  constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  const size_t n = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  char32_t code = lead & (0x7fu >> n);
  for (size_t i = 1; i < n; ++i) {
    if (i >= text.size() || !is_continuation(text[i])) return {1, lead, false};
    code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3fu);
  }
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  const bool is_good =
      lead >= 0xc2 && lead < 0xf8 && code >= kLeast[n] && code <= 0x10ffff && !is_surrogate;
  return is_good ? Character{n, code, true} : Character{1, lead, false};
}

/// False: a control character (C0 or C1), or one that changes the writing direction or ends a line.
bool is_printable(char32_t code) {
  const auto within = [code](char32_t first, char32_t last) {
    return code >= first && code <= last;
  };
  return !(within(0, 0x1f) || within(0x7f, 0x9f) || code == 0x61c || within(0x200e, 0x200f) ||
           within(0x2028, 0x202e) || within(0x2066, 0x2069));
}

std::string escape(const Character& c) {
  if (c.code == '\n') return "\\n";
  if (c.code == '\r') return "\\r";
  if (c.code == '\t') return "\\t";
  constexpr std::string_view kDigits = "0123456789abcdef";
  const bool is_wide = c.is_utf8 && c.code > 0x7f;
  std::string out = is_wide ? "\\u" : "\\x";
  for (int shift = is_wide ? 12 : 4; shift >= 0; shift -= 4) out += kDigits[c.code >> shift & 0xf];
  return out;
}

std::string escape(std::string_view text) {
  std::string out;
  for (; !text.empty();) {
    const Character c = first_character(text);
    c.is_utf8&& is_printable(c.code) ? out += text.substr(0, c.bytes) : out += escape(c);
    text.remove_prefix(c.bytes);
  }
  return out;
}

std::string_view first_characters(std::string_view text, size_t n) {
  size_t end = 0;
  for (; end < text.size(); ++end) {
    if (!is_continuation(text[end]) && n-- == 0) break;
  }
  return text.substr(0, end);
}

std::string_view last_characters(std::string_view text, size_t n) {
  const size_t all = count_characters(text);
  return text.substr(first_characters(text, all - std::min(all, n)).size());
}

/// Levenshtein distance: insertions, deletions and substitutions that turn a into b.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

size_t count_characters(std::string_view text) {
  const auto n =
      std::count_if(text.begin(), text.end(), [](char c) { return !is_continuation(c); });
  return static_cast<size_t>(n);
}

std::string printable(std::string_view text, size_t most) {
  // escapes only the two ends of a huge text: a character has at most four bytes
  const size_t window = 4 * most;
  if (text.size() <= 2 * window) {
    std::string whole = escape(text);
    if (count_characters(whole) <= most) return whole;
  }
  const std::string gap = "…(" + std::to_string(text.size()) + " bytes)…";
  const size_t left = most - std::min(count_characters(gap), most);
  const std::string head = escape(text.substr(0, window));
  const std::string tail = escape(text.substr(text.size() - std::min(window, text.size())));
  return std::string(first_characters(head, left - left / 3)) + gap +
         std::string(last_characters(tail, left / 3));
}

std::string shown(std::string_view foreign) {
  return printable(foreign, kLongestShown);
}

std::string one_line(std::string_view message) {
  return printable(message, kLongestMessage);
}

std::string_view nearest_word(std::string_view word, const std::vector<std::string_view>& known) {
  constexpr size_t kShortestBeginning = 3;
  std::string_view nearest;
  size_t least = std::max<size_t>(2, word.size() / 3) + 1;
  for (const std::string_view k : known) {
    const bool goes_on = word.size() >= kShortestBeginning && k.starts_with(word);
    if (const size_t d = goes_on ? 1 : edit_distance(word, k); d < least) {
      least = d;
      nearest = k;
    }
  }
  return nearest;
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& known) {
  const std::string_view nearest = nearest_word(word, known);
  if (!nearest.empty()) return "did you mean '" + std::string(nearest) + "'?";
  return "known here: " + joined(known);
}

}  // namespace haptic
