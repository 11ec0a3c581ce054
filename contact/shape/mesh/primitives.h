// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

struct Soup {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Closed box centred at the origin, 12 triangles.
Soup make_box(const Vec3& extent);

/// Geodesic sphere at the origin: 20·4ⁿ triangles with vertices on the sphere.
Soup make_icosphere(double radius, uint32_t subdivisions);

/// Unit sphere at the origin, from an icosahedron whose sides are divided into f parts: 20 f²
/// triangles.
Soup make_geodesic(uint32_t f);

/// Open square [-half, half]² in z = 0, n × n quads of two triangles, facing +z.
Soup make_grid(double half, uint32_t n);

}  // namespace haptic
