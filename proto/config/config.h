// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/config/session_config.h"

namespace haptic {

/// Reads, checks and resolves a TOML session file: the session as each of its hands has it, by
/// number; without [[hand]] there is one. Quantities are strings with a unit ("800 N/m", "2 mm",
/// "1 kHz"); relative paths are relative to the folder of the file. Throws ConfigError.
std::vector<SessionConfig> load_hands(const std::string& path);

/// Parses text; `origin` is the path in messages and the base of relative paths.
std::vector<SessionConfig> parse_hands(std::string_view toml_text, const std::string& origin);

/// The session as its first hand has it.
SessionConfig load_config(const std::string& path);
SessionConfig parse_config(std::string_view toml_text, const std::string& origin);

/// Longest session file [bytes]: four times our longest, and more than a scene full of objects
/// needs. The TOML parser recurses per nested table, with 270 bytes of stack for two bytes of text
/// ("a."): at most 4.4 MB of the usual 8. hapticd sends the text in one message of the control
/// socket.
inline constexpr size_t kMostConfigText = size_t{32} << 10;

/// The unchanged text of a session file, for recordings. Throws ConfigError.
std::string read_config_text(const std::string& path);

}  // namespace haptic
