// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

/// A message goes to a terminal or a log, and much of it was written by others: names of files,
/// what was typed, what came over a socket. None of that may move the cursor, colour the line,
/// begin another one, or bury what the message says.
namespace haptic {

/// Longest piece of foreign text within a message, and longest message [characters].
inline constexpr size_t kLongestShown = 80;
inline constexpr size_t kLongestMessage = 1000;

/// Text as it may stand in one line of at most `most` characters, 40 or more. Printable UTF-8 stays
/// as it is. Escaped are control characters ("\n", "\x1b", "\u009b"), the marks that turn the
/// direction of writing or end a line ("\u202e"), and bytes that are no UTF-8 ("\xff"); a backslash
/// stays, so that to do it twice changes nothing. What is longer keeps its beginning and its end,
/// with the number of bytes between: "beginning…(5000 bytes)…end".
std::string printable(std::string_view text, size_t most);

/// Foreign text as it may stand within a message.
std::string shown(std::string_view foreign);

/// A whole message as it may be printed: one line. The last guard, at the doors of each program.
std::string one_line(std::string_view message);

/// What is wrong, where, and how to mend it; always one line.
struct MessageError : std::runtime_error {
  explicit MessageError(std::string_view message) : std::runtime_error(one_line(message)) {}
};

}  // namespace haptic
