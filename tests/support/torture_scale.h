// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>

namespace haptic::test {

/// How much longer than in CI: the environment's HAPTIC_TORTURE_SCALE, 1 where it is not set.
inline double torture_scale() {
  const char* text = std::getenv("HAPTIC_TORTURE_SCALE");
  return text != nullptr ? std::strtod(text, nullptr) : 1;
}

}  // namespace haptic::test
