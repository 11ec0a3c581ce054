// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "contact/bake/soup/report.h"

namespace haptic {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::string_view kBlanksAndEnd = " \t\r\v\f\n";
constexpr size_t kLongestQuote = 40;  // of a word in an error message: half a line of a terminal

/// A word of the file, made printable on one line.
std::string printable(std::string_view word) {
  std::string text(word.substr(0, kLongestQuote));
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return word.size() > kLongestQuote ? text + "..." : text;
}

}  // namespace

std::string_view TextCursor::word_on_line() {
  rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
  const size_t end = std::min(rest_.find_first_of(kBlanksAndEnd), rest_.size());
  if (end > 0 && rest_[0] == '#') return {};
  const std::string_view word = rest_.substr(0, end);
  rest_.remove_prefix(end);
  return word;
}

std::string_view TextCursor::word() {
  for (;;) {
    const std::string_view found = word_on_line();
    if (!found.empty() || !next_line()) return found;
  }
}

bool TextCursor::next_line() {
  const size_t end = rest_.find('\n');
  if (end == std::string_view::npos) {
    rest_ = {};
    return false;
  }
  rest_.remove_prefix(end + 1);
  ++line_;
  return true;
}

void TextCursor::fail(const std::string& what) const {
  throw MeshError(path_ + ":" + std::to_string(line_) + ": " + what);
}

double TextCursor::coordinate(std::string_view text) const {
  if (text.empty()) fail("the file ends within a vertex: truncated; export it again");
  const bool plus = text[0] == '+';
  const char* const begin = text.data() + plus;
  const char* const end = text.data() + text.size();
  double value = 0;
  const auto [parsed, error] = std::from_chars(begin, end, value);
  if (error == std::errc::invalid_argument || parsed != end || (plus && *begin == '-')) {
    fail("'" + printable(text) + "' is not a number; export the mesh again");
  }
  // from_chars does not distinguish overflow from underflow
  if (error != std::errc{}) value = std::strtod(std::string(begin, end).c_str(), nullptr);
  if (!std::isfinite(value)) {
    fail("coordinate '" + printable(text) + "' is not finite; export the mesh again");
  }
  return value;
}

int64_t TextCursor::integer(std::string_view text, const char* what) const {
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) {
    fail(std::string(what) + " expected, '" + printable(text) +
         "' found: truncated or damaged; export the mesh again");
  }
  return value;
}

uint64_t TextCursor::index(std::string_view text, uint64_t limit) const {
  const int64_t value = integer(text, "a vertex index");
  if (value < 0 || static_cast<uint64_t>(value) >= limit) {
    fail("vertex index " + std::to_string(value) + " is out of range 0 to " +
         std::to_string(static_cast<int64_t>(limit) - 1) + "; export the mesh again");
  }
  return static_cast<uint64_t>(value);
}

uint64_t TextCursor::count(std::string_view text) const {
  const int64_t value = integer(text, "a count");
  if (value < 0) fail("negative count " + std::to_string(value) + "; export the mesh again");
  return static_cast<uint64_t>(value);
}

}  // namespace haptic
