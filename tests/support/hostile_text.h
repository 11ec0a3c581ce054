// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iconv.h>

#include <exception>
#include <sstream>
#include <string>
#include <vector>

namespace haptic::test {

/// Hostile texts in place of a name or a value.
inline const std::vector<std::string> kHostileTexts{"\x1b]0;owned\x07\x1b[2J\x1b[31m",
                                                    "two\nlines\r",
                                                    "\x7f\b\b\t",
                                                    "\u009b31m \x9b"
                                                    "31m",
                                                    "Sch\xe4"
                                                    "del\xff",
                                                    "gnp.\u202eexe",
                                                    std::string(5000, 'A'),
                                                    std::string(4000, '\x1b')};

/// The code points of a text by the C library; `is_utf8`: whether it is valid.
inline std::u32string code_points(std::string text, bool& is_utf8) {
  std::u32string out(text.size(), U'\0');
  char* in = text.data();
  char* begin = reinterpret_cast<char*>(out.data());
  char* end = begin;
  size_t in_left = text.size(), out_left = 4 * out.size();
  const iconv_t converter = iconv_open("UTF-32LE", "UTF-8");
  is_utf8 = iconv(converter, &in, &in_left, &end, &out_left) != static_cast<size_t>(-1);
  iconv_close(converter);
  out.resize(static_cast<size_t>(end - begin) / 4);
  return out;
}

/// Number of characters.
inline size_t length(const std::string& text) {
  bool is_utf8 = false;
  return code_points(text, is_utf8).size();
}

/// The message of the error that this throws; empty if it throws none.
template <class Error = std::exception, class Use>
std::string refusal(const Use& use) {
  try {
    use();
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

/// Defects of a program's output; empty if it is whole lines of printable UTF-8, none of them
/// longer than a message preceded by the name of a program and the time.
inline std::string problem_of_message(const std::string& printed) {
  constexpr size_t kLongest = 1000 + 120;  // [characters]
  if (!printed.empty() && printed.back() != '\n') return "does not end its line";
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);) {
    bool is_utf8 = false;
    const std::u32string codes = code_points(line, is_utf8);
    if (!is_utf8) return "is no UTF-8";
    if (codes.size() > kLongest) return std::to_string(codes.size()) + " characters in a line";
    for (const char32_t code : codes) {
      const bool is_control = code < 0x20 || (code >= 0x7f && code < 0xa0);
      if (is_control || code == 0x2028 || code == 0x202e) {
        return "holds the control character " + std::to_string(static_cast<uint32_t>(code));
      }
    }
  }
  return "";
}

}  // namespace haptic::test
