// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "device-io/motors/arm.h"
#include "proto/math/vec3.h"

namespace haptic {

/// A five-bar linkage in the plane z = 0 of B: two driven links, whose motors stand `base` apart on
/// the x axis with B's origin in their middle, and two more that join in the handle. Motor 1 is at
/// x = −base/2. Both elbows point outwards, and the handle is on the side of the elbows' line that
/// is to the left on the way from elbow 1 to elbow 2.
struct PantographGeometry {
  double proximal = 0.05;  // length of the driven links [m]
  double distal = 0.07;    // of the others [m]
  double base = 0.02;      // [m]
};

/// Angles of the driven links from the x axis, counter-clockwise about z [rad].
using PantographAngles = std::array<double, 2>;

/// Handle of these angles: with the elbows A = (−base/2 + l cos θ₁, l sin θ₁), B likewise, their
/// middle M and n the unit normal of B − A, p = M + n √(L² − |B − A|²/4). False, and p_B stays,
/// where no handle has these angles, or the linkage is singular: the distal links are in one line,
/// or the elbows meet.
bool find_pantograph_handle(const PantographGeometry& geometry, const PantographAngles& angles,
                            Vec3& p_B);

/// First moment in B of both driven links and both others: x along the link, from its motor or its
/// elbow on; y to the outside of the linkage, so that both sides are each other's mirror image.
Vec3 pantograph_moment(const PantographGeometry& geometry, const LinkMasses& links,
                       const PantographAngles& angles, const Vec3& p_B);

/// Velocity of the handle per angular velocity of each driven link, ∂p/∂θᵢ [m/rad]. Since a distal
/// link uᵢ from elbow to handle keeps its length, uᵢ · ṗ = uᵢ · tᵢ θ̇ᵢ with the elbow's velocity tᵢ
/// per θ̇ᵢ. False where the distal links are in one line.
bool pantograph_jacobian(const PantographGeometry& geometry, const PantographAngles& angles,
                         const Vec3& p_B, std::array<Vec3, 2>& J);

}  // namespace haptic
