// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/mat3.h"

namespace haptic {

/// Mass properties of a body of uniform density 1 kg/m³.
struct MassProperties {
  double volume = 0;                                  // [m³]; numerically the mass
  Vec3 centre_O;                                      // centre of mass
  Mat3 inertia_O{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};  // about the centre, axes of O [m⁵]
};

/// For a closed, outward-oriented mesh, by tetrahedra over its triangles: exact up to rounding. I =
/// tr(C) 1 − C, C = ∫ r rᵀ about the centre.
MassProperties mass_properties(const TriangleMesh& mesh);

/// Of a closed mesh that, of another, which has no inside, those of its bounding box.
MassProperties solid_properties(const TriangleMesh& mesh);

}  // namespace haptic
