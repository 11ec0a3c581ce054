// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/tool_body.h"

#include <algorithm>

#include "contact/shape/mesh/mass_properties.h"

namespace haptic {
namespace {

/// Mass properties at a density of 1 kg/m³.
MassProperties filled_box(const Vec3& lower, const Vec3& upper) {
  const Vec3 d = upper - lower;
  MassProperties box;
  box.volume = d.x * d.y * d.z;
  box.centre_O = 0.5 * (lower + upper);
  const double m = box.volume / 12;
  box.inertia_O.row[0].x = m * (d.y * d.y + d.z * d.z);
  box.inertia_O.row[1].y = m * (d.z * d.z + d.x * d.x);
  box.inertia_O.row[2].z = m * (d.x * d.x + d.y * d.y);
  return box;
}

}  // namespace

ToolBody tool_body(const TriangleMesh& mesh, const ToolConfig& config) {
  MassProperties filled = mesh.closed ? mass_properties(mesh) : MassProperties{};
  if (!(filled.volume > 0)) filled = filled_box(mesh.lower, mesh.upper);
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
