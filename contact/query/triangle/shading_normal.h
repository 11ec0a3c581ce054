// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Unit normal for force shading at point_O on a triangle: its three corner normals, interpolated
/// in barycentric coordinates. A corner normal is the angle-weighted mean over the faces around the
/// corner that connect to the triangle through edges that turn by less than the crease angle (given
/// as its cosine); a walk of at most 64 faces each way. Source: Phong 1975, as used by Ruspini,
/// Kolarov, Khatib 1997.
Vec3 shading_normal(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O,
                    double crease_cosine);

}  // namespace haptic
