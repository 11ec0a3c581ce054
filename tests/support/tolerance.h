// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>

namespace haptic::test {

/// A tolerance scaled by HAPTIC_TOL_SCALE (default 1). With 0 every comparison prints its true
/// residual and fails.
inline double tol(double value) {
  const char* scale = std::getenv("HAPTIC_TOL_SCALE");
  return scale != nullptr ? value * std::atof(scale) : value;
}

}  // namespace haptic::test
