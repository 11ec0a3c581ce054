// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/mat3.h"

namespace haptic {

/// A body filled evenly with a density of 1 kg/m³.
struct MassProperties {
  double volume = 0;                                  // [m³], and the mass
  Vec3 centre_O;                                      // of mass
  Mat3 inertia_O{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};  // about the centre, axes of O [m⁵]
};

/// Of a closed mesh that faces outwards, by tetrahedra over its triangles: exact but for rounding.
/// I = tr(C) 1 − C, C = ∫ r rᵀ about the centre.
MassProperties mass_properties(const TriangleMesh& mesh);

}  // namespace haptic
