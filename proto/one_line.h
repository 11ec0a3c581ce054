// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

namespace haptic {

/// A text that quotes what came from elsewhere, fit for a terminal and a log: control characters
/// become '?', and what is longer than `longest` bytes is cut.
inline std::string one_line(std::string text, size_t longest = 2000) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  if (text.size() <= longest) return text;
  // not within a character of UTF-8: its other bytes are 10xxxxxx
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0) == 0x80) --longest;
  return text.substr(0, longest) + "…";
}

}  // namespace haptic
