// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/conservative_advancement.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kRounding = 1e-12;  // relative, of the speed

/// Upper bound of the speed of any vertex, per unit of time [m].
double fastest(const TriangleMesh& mesh, const RigidMotion& motion) {
  double radius2 = 0;
  for (const Vec3& v : mesh.vertices) {
    radius2 = std::max(radius2, norm_squared(v - motion.centre_T));
  }
  return (1 + kRounding) * (norm(motion.way_O) + motion.angle * std::sqrt(radius2));
}

}  // namespace

Advancement advance(const MeshShape& shape_A, const MeshShape& shape_B, const RigidMotion& motion,
                    const AdvancementOptions& options) {
  Advancement result;
  const double speed = fastest(shape_B.mesh, motion);
  if (!std::isfinite(speed) || !is_finite(motion.at(0)) || !(options.tolerance > 0)) {
    result.is_ended = true;
    return result;
  }
  TrianglePair witness;
  bool has_witness = false;
  while (result.steps < options.steps) {
    ++result.steps;
    // pairs farther apart than the rest of the way cannot meet
    const double rest = speed * (1 - result.time);
    const MeshDistance apart =
        mesh_distance(shape_A, shape_B, motion.at(result.time), rest + options.tolerance,
                      has_witness ? &witness : nullptr);
    if (!apart.found) {
      result.time = 1;
      return result;
    }
    result.nearest = apart.nearest;
    if (apart.at_least <= options.tolerance) {
      result.is_hit = true;
      return result;
    }
    witness = apart.nearest.triangles;
    has_witness = true;
    const double next = result.time + (apart.at_least - 0.5 * options.tolerance) / speed;
    if (!(next < 1)) {
      result.time = 1;
      return result;
    }
    result.time = next;
  }
  result.is_ended = true;
  return result;
}

}  // namespace haptic
