// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "proto/math/vec3.h"

namespace haptic {

/// Shortens a vector to its limit, so that it keeps its direction; one that is not finite becomes
/// zero. True: it was changed.
inline bool saturate(Vec3& a, double limit) {
  const double size = norm(a);
  if (size <= limit) return false;
  a = std::isfinite(size) ? limit / size * a : Vec3{};
  return true;
}

}  // namespace haptic
