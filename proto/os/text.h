// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "proto/os/message.h"

/// Texts of a given form, and numbers that are read out of texts.
namespace haptic {

/// Filled up with blanks to so many characters, and one at least where it is longer.
inline std::string padded(const std::string& text, size_t width) {
  const size_t n = count_characters(text);
  return text + std::string(n < width ? width - n : width > 0, ' ');
}

/// As printf would print it, cut at 511 characters.
std::string formatted(const char* pattern, auto... values) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

/// The text with some pieces replaced, each by what stands beside it; of two that fit at one place
/// the first counts.
inline std::string replaced(
    std::string_view text,
    std::initializer_list<std::pair<std::string_view, std::string_view>> pieces) {
  std::string out;
  while (!text.empty()) {
    const auto fits = [&](const auto& piece) { return text.starts_with(piece.first); };
    const auto found = std::ranges::find_if(pieces, fits);
    const bool is_found = found != pieces.end();
    out += is_found ? found->second : text.substr(0, 1);
    text.remove_prefix(is_found ? found->first.size() : 1);
  }
  return out;
}

/// The number that is the whole of a text; none if the text is none, or not that alone.
template <typename Number>
std::optional<Number> number_from(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && at == end ? std::optional(number) : std::nullopt;
}

}  // namespace haptic
