// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace haptic {

/// Longest session file [bytes]: four times the longest of ours, and more than a scene full of
/// objects takes. The TOML parser calls itself for each table within another, which takes two bytes
/// of text ("a.") and 270 of its stack: at most 4.4 MB of the usual 8. hapticd hands the text out
/// in one message of the control socket.
inline constexpr size_t kMostConfigText = size_t{32} << 10;

}  // namespace haptic
