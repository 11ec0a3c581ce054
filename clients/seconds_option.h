// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <string>

namespace haptic {

/// Accepts a length of time on the command line: a plain number of seconds, above zero, at most a
/// month.
inline CLI::Validator seconds_option() {
  constexpr double kMonth = 31 * 86400.0;
  const auto check = [](const std::string& text) -> std::string {
    double seconds = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, seconds);
    // written so that NaN is refused
    const bool good = error == std::errc() && stop == end && seconds > 0 && seconds <= kMonth;
    return good ? "" : "'" + text + "' is not a number of seconds above 0, as 20 or 0.5";
  };
  return CLI::Validator(check, "SECONDS");
}

}  // namespace haptic
