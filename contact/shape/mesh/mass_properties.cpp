// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/mass_properties.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

Mat3 outer(const Vec3& a) {
  return {{a.x * a, a.y * a, a.z * a}};
}

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

MassProperties mass_properties(const TriangleMesh& mesh) {
  HAPTIC_ASSERT(mesh.closed || mesh.triangles.empty());
  const Vec3 origin_O = 0.5 * (mesh.lower + mesh.upper);
  double volume = 0;
  Vec3 first;
  Mat3 second{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [p, q, r] = corners_of(mesh, t);
    const Vec3 a = p - origin_O, b = q - origin_O, c = r - origin_O;
    const double v = dot(a, cross(b, c)) / 6;
    volume += v;
    first += (v / 4) * (a + b + c);
    second = second + (v / 20) * (outer(a + b + c) + outer(a) + outer(b) + outer(c));
  }
  if (!(volume > 0)) return {};
  const Vec3 centre = first / volume;
  const Mat3 about = second + (-volume) * outer(centre);
  const double trace = about.row[0].x + about.row[1].y + about.row[2].z;
  return {volume, origin_O + centre, trace * Mat3{} + (-1.0) * about};
}

MassProperties solid_properties(const TriangleMesh& mesh) {
  const MassProperties filled = mesh.closed ? mass_properties(mesh) : MassProperties{};
  return filled.volume > 0 ? filled : filled_box(mesh.lower, mesh.upper);
}

}  // namespace haptic
