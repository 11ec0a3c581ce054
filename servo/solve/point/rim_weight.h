// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

/// What is left of a contact `along` its plane from its point: all within its extent, nothing a
/// tenth further [m].
inline double rim_weight(double along, double extent) {
  constexpr double kRim = 0.1;  // of the extent
  const double rim = kRim * extent, beyond = along - extent;
  if (beyond <= 0) return 1;
  return beyond < rim ? 1 - beyond / rim : 0;
}

}  // namespace haptic
