// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

/// Weight of a contact at the distance `along` its plane from its point [m]: 1 within the extent,
/// falling linearly to 0 a tenth of the extent beyond it.
inline double rim_weight(double along, double extent) {
  constexpr double kRim = 0.1;  // width of the fade, as a share of the extent
  const double rim = kRim * extent, beyond = along - extent;
  if (beyond <= 0) return 1;
  return beyond < rim ? 1 - beyond / rim : 0;
}

}  // namespace haptic
