// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/shading_normal.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMaxFan = 64;  // faces around one corner

/// A face, and which of its corners is the pivot of the walk.
struct Corner {
  uint32_t triangle;
  size_t corner;
};

Vec3 weighted_normal(const TriangleMesh& mesh, const Corner& at) {
  const Triangle& tri = mesh.triangles[at.triangle];
  const Vec3& p = mesh.vertices[tri[at.corner]];
  const Vec3 a = mesh.vertices[tri[(at.corner + 1) % 3]] - p;
  const Vec3 b = mesh.vertices[tri[(at.corner + 2) % 3]] - p;
  return std::atan2(norm(cross(a, b)), dot(a, b)) * mesh.face_normals[at.triangle];
}

/// The next face around the pivot, over the side after it (turn = 0) or before it (turn = 2); false
/// at a border or a crease.
bool turn_around(const TriangleMesh& mesh, size_t turn, double crease_cosine, Corner& at) {
  const uint32_t vertex = mesh.triangles[at.triangle][at.corner];
  const uint32_t next = neighbour_across(mesh, at.triangle, (at.corner + turn) % 3);
  if (next == kNoFace) return false;
  if (dot(mesh.face_normals[next], mesh.face_normals[at.triangle]) < crease_cosine) return false;
  const Triangle& tri = mesh.triangles[next];
  at = {next, static_cast<size_t>(std::find(tri.begin(), tri.end(), vertex) - tri.begin())};
  return at.corner < 3;
}

Vec3 corner_normal(const TriangleMesh& mesh, uint32_t triangle, size_t corner,
                   double crease_cosine) {
  const Corner start{triangle, corner};
  Vec3 sum = weighted_normal(mesh, start);
  Corner at = start;
  int left = kMaxFan;
  while (left-- > 0 && turn_around(mesh, 0, crease_cosine, at)) {
    if (at.triangle == triangle) return normalized(sum);  // closed fan
    sum += weighted_normal(mesh, at);
  }
  at = start;
  left = kMaxFan;
  while (left-- > 0 && turn_around(mesh, 2, crease_cosine, at) && at.triangle != triangle) {
    sum += weighted_normal(mesh, at);
  }
  return normalized(sum);
}

}  // namespace

Vec3 shading_normal(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O,
                    double crease_cosine) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size());
  HAPTIC_ASSERT(crease_cosine >= -1 && crease_cosine <= 1);
  const Triangle& tri = mesh.triangles[triangle];
  const Vec3& n = mesh.face_normals[triangle];
  Vec3 sum;
  for (size_t i = 0; i < 3; ++i) {
    const Vec3& a = mesh.vertices[tri[(i + 1) % 3]];
    const Vec3& b = mesh.vertices[tri[(i + 2) % 3]];
    // twice the area of the opposite sub-triangle: the barycentric coordinate times a constant
    const double share = std::max(dot(n, cross(a - point_O, b - point_O)), 0.0);
    sum += share * corner_normal(mesh, triangle, i, crease_cosine);
  }
  const Vec3 shaded = normalized(sum);
  return norm_squared(shaded) > 0 ? shaded : n;
}

}  // namespace haptic
