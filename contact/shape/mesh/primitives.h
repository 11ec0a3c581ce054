// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/config/primitive.h"

namespace haptic {

struct Soup {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

// make_box, make_peg …: the mesh of each kind by its dimensions [m], the same each time
#define PRIMITIVE(Kind, name, make) Soup make(const primitive::Kind& kind);
#include "proto/config/primitives.def"

/// The mesh of a primitive [m]; of none it is empty.
Soup make_mesh(const Primitive& primitive);

/// Geodesic sphere at the origin: 20·4ⁿ triangles with vertices on the sphere.
Soup make_icosphere(double radius, uint32_t subdivisions);

/// Unit sphere at the origin, from an icosahedron whose sides are divided into f parts: 20 f²
/// triangles.
Soup make_geodesic(uint32_t f);

/// Open square [-half, half]² in z = 0, n × n quads of two triangles, facing +z.
Soup make_grid(double half, uint32_t n);

}  // namespace haptic
