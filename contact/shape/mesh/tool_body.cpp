// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/tool_body.h"

#include <algorithm>

#include "contact/shape/mesh/mass_properties.h"

namespace haptic {

ToolBody tool_body(const TriangleMesh& mesh, const ToolConfig& config) {
  const MassProperties filled = solid_properties(mesh);
  ToolBody body{};
  body.centre_T = filled.centre_O;
  body.mass =
      config.density > 0 && filled.volume > 0 ? config.density * filled.volume : config.mass;
  body.inertia_T = config.inertia;
  if (body.inertia_T == Vec3{} && filled.volume > 0) {
    const double density = body.mass / filled.volume;
    const Mat3& I = filled.inertia_O;
    body.inertia_T = density * Vec3{I.row[0].x, I.row[1].y, I.row[2].z};
  }
  for (const Vec3& v : mesh.vertices) {
    body.radius = std::max(body.radius, norm(v - body.centre_T));
  }
  // a flat or pointed tool must be able to rotate: as if its mass were at its rim
  if (body.inertia_T == Vec3{}) {
    const double ring = body.mass * body.radius * body.radius;
    body.inertia_T = {ring, ring, ring};
  }
  return body;
}

}  // namespace haptic
