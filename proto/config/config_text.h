// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace haptic {

/// Longest session file [bytes]: four times our longest, and more than a scene full of objects
/// needs. The TOML parser recurses per nested table, with 270 bytes of stack for two bytes of text
/// ("a."): at most 4.4 MB of the usual 8. hapticd sends the text in one message of the control
/// socket.
inline constexpr size_t kMostConfigText = size_t{32} << 10;

}  // namespace haptic
