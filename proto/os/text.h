// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

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

/// The number that is the whole of a text; none if the text is none, or not that alone.
template <typename Number>
std::optional<Number> number_from(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && at == end ? std::optional(number) : std::nullopt;
}

}  // namespace haptic
