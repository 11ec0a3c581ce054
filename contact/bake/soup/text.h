// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace haptic {

/// Tokenizer of text mesh files that counts lines. Words are separated by blanks, tabs and carriage
/// returns; a word that begins with '#' starts a comment.
class TextCursor {
 public:
  /// `path` begins every error message; it must outlive the cursor.
  TextCursor(std::string_view text, const std::string& path) : rest_(text), path_(path) {}

  /// Next word on this line; empty at its end or at a comment.
  std::string_view word_on_line();
  /// Next word anywhere; empty at the end of the file.
  std::string_view word();
  /// Goes to the start of the next line; false if there is none.
  bool next_line();
  std::string_view rest() const { return rest_; }

  /// Throws MeshError "path:line: what".
  [[noreturn]] void fail(const std::string& what) const;

  /// Parse a word as a finite number, an integer, an index below `limit`, or a count; throw
  /// MeshError if it is none. A number too small for a double is 0.
  double coordinate(std::string_view text) const;
  int64_t integer(std::string_view text, const char* what) const;
  uint64_t index(std::string_view text, uint64_t limit) const;
  uint64_t count(std::string_view text) const;

 private:
  std::string_view rest_;
  const std::string& path_;
  size_t line_ = 1;
};

}  // namespace haptic
