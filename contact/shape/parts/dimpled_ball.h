// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Of a dimpled ball: they lie about the vertices of a geodesic sphere.
inline constexpr uint32_t kDimples = 362;
/// Angle between a dimple's middle and its rim, seen from the ball's centre [rad]; the nearest two
/// middles are 0.163 apart.
inline constexpr double kDimpleAngle = 0.08;

}  // namespace haptic
