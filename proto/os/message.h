// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Messages go to a terminal or a log, and parts of them are foreign: file names, typed text, bytes
/// from a socket. None of these may move the cursor, change colours, start another line, or hide
/// the rest of the message.
namespace haptic {

/// Longest foreign text within a message, and longest message [characters].
inline constexpr size_t kLongestShown = 80;
inline constexpr size_t kLongestMessage = 1000;

/// Text made safe for one line of at most `most` characters (at least 40). Printable UTF-8 is
/// unchanged. Escaped are control characters ("\n", "\x1b", "\u009b"), marks that change the
/// writing direction or end a line ("\u202e"), and bytes that are not UTF-8 ("\xff"). A backslash
/// is unchanged, so the function is idempotent. Longer text keeps its beginning and end, with the
/// number of bytes between: "beginning…(5000 bytes)…end".
std::string printable(std::string_view text, size_t most);

/// Number of characters of a UTF-8 text.
size_t count_characters(std::string_view text);

/// Foreign text for use within a message.
std::string shown(std::string_view foreign);

/// A whole message made safe for one line; applied last, at each program's output.
std::string one_line(std::string_view message);

/// An error for people: what is wrong, where, and how to mend it; always one line.
struct MessageError : std::runtime_error {
  explicit MessageError(std::string_view message) : std::runtime_error(one_line(message)) {}
};

/// The mistake is in the command line, the session file or a file that one of them names: exit code
/// 2 of every program, where other failures are 1.
struct InputError : MessageError {
  using MessageError::MessageError;
};

/// "a, b, c": the texts of some items, which are the items themselves where `text_of` is left out.
template <typename Items, typename TextOf = std::identity>
std::string joined(Items&& items, const TextOf& text_of = {}) {
  std::string out;
  for (const auto& item : items) {
    out += out.empty() ? "" : ", ";
    out += std::invoke(text_of, item);
  }
  return out;
}

/// The known word that a mistyped one most resembles: few letters differ, or it only goes on.
/// Empty: none does.
std::string_view nearest_word(std::string_view word, const std::vector<std::string_view>& known);

/// "did you mean 'max_force'?", else "known here: max_force, max_torque".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& known);

}  // namespace haptic
