// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

/// How a test takes the stubs' device away: by more force than such a device has [N].
inline bool tears_plug_out(const double f[3]) {
  return std::hypot(f[0], f[1], f[2]) > 25;
}
