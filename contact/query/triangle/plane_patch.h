// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// The part of a surface around a point that a contact plane stands in for.
struct PlanePatch {
  double extent = 0;     // distance to where it ends [m]; 0: the surface turns away right there
  double curvature = 0;  // its least normal curvature, where it is convex [1/m]; 0: flat or unknown
};

/// Walks over the mesh from point_O, which lies on `triangle`, in eight directions along the plane
/// with normal_O. A walk ends at a border or at a convex edge behind which the surface turns from
/// the plane by more than 25°, after 24 triangles or at kMaxExtent; a concave edge does not limit
/// the plane, which lies inside the object behind it. extent = cos 22.5° · the shortest walk: the
/// distance of a straight edge between two directions.
///
/// Curvature: in direction θ the surface lies h below the plane at a distance ρ of about 4 mm, so
/// κ(θ) = 2 h/ρ². By Euler's theorem κ(θ) = a + b cos 2θ + c sin 2θ, of which the least is
/// a − √(b² + c²); the least of the eight bounds it as well, and what is not convex in every
/// direction counts as flat. So the smooth surface that the mesh stands for lies, to second order,
/// at least ½ κ |δ|² below the plane at each place δ within the extent. Our own estimator.
PlanePatch plane_patch(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O,
                       const Vec3& normal_O);

}  // namespace haptic
