// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "contact/shape/convex/hull.h"
#include "proto/math/pose.h"

namespace haptic {

/// Corners of a convex polyhedron: n points on an ellipsoid with half axes of 20, 14 and 10 mm,
/// each the farthest of twelve random ones from those before. All are corners; exact floats.
std::vector<Vec3> make_convex_points(uint32_t n, uint64_t seed);

/// Workload W4: n poses X_AB at 1 kHz of a convex polyhedron that turns and moves around another at
/// rest, so that along the direction between their origins they overlap by 0.2 to 3.8 mm. Poses
/// with a penetration depth of less than 0.01 mm are left out.
std::vector<Pose> make_convex_poses(const Hull& a, const Hull& b, size_t n);

/// Vertices of the pairs of W4, and their seeds.
inline constexpr uint32_t kConvexSizes[] = {20, 50, 100, 200, 500};
inline uint64_t convex_seed_A(uint32_t n) {
  return 1000 + n;
}
inline uint64_t convex_seed_B(uint32_t n) {
  return 2000 + n;
}

}  // namespace haptic
