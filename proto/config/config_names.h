// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "proto/os/message.h"

/// Texts of fixed size, as configurations and messages between processes hold them.
namespace haptic {

using Name = std::array<char, 64>;   // zero-terminated
using Path = std::array<char, 512>;  // zero-terminated

/// A mistake in a session file: one line "file:line:column: what; how to mend".
struct ConfigError : InputError {
  using InputError::InputError;
};

/// Why a session cannot have this name, which becomes the name of a socket, and how to mend it;
/// empty if it can.
std::string session_name_problem(std::string_view name);
/// Likewise of a hand, which people name on the command line.
std::string hand_name_problem(std::string_view name);

/// Copies text into a fixed array; throws ConfigError if it does not fit.
template <size_t N>
void assign(std::array<char, N>& out, std::string_view text) {
  if (text.size() >= N) {
    throw ConfigError("'" + shown(text) + "' is longer than " + std::to_string(N - 1) +
                      " characters; shorten it");
  }
  out = {};
  text.copy(out.data(), N - 1);
}

template <size_t N>
std::string_view view(const std::array<char, N>& text) {
  return std::string_view(text.data());
}

}  // namespace haptic
