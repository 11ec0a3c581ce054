// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// A ball with dimples, as for golf, about the origin. The 362 dimples lie about the vertices of a
/// geodesic sphere; each is a paraboloid with a sharp rim.
struct DimpledBall {
  double diameter = 42.7e-3;  // between the dimples [m]
  double depth = 0.25e-3;     // of a dimple's middle [m]; 0: a plain ball
  uint32_t steps = 82;        // along a side of the icosahedron: 20·steps² triangles
};
inline constexpr uint32_t kDimples = 362;
/// Angle between a dimple's middle and its rim, seen from the ball's centre [rad]; the nearest two
/// middles are 0.163 apart.
inline constexpr double kDimpleAngle = 0.08;

Soup make_dimpled_ball(const DimpledBall& ball);

}  // namespace haptic
