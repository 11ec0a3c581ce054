// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace haptic {

using Name = std::array<char, 64>;   // zero-terminated
using Path = std::array<char, 512>;  // zero-terminated

}  // namespace haptic
