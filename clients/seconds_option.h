// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <string>

namespace haptic {

/// What is wrong with a length of time on the command line, which is to be a plain number of
/// seconds, above zero, at most a month; empty: nothing.
inline std::string problem_of_seconds(const std::string& text) {
  constexpr double kMonth = 31 * 86400.0;
  double seconds = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seconds);
  // written so that NaN is refused
  const bool good = error == std::errc() && stop == end && seconds > 0 && seconds <= kMonth;
  return good ? "" : "'" + text + "' is not a number of seconds above 0, as 20 or 0.5";
}

}  // namespace haptic
