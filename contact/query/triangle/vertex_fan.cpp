// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/vertex_fan.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kOver = 1.0 / 32;  // height above the surface per distance from the vertex

struct FanCorner {
  uint32_t triangle;
  size_t corner;
};

/// Steps to the triangle across a side at the vertex; false at a border.
bool turn(const TriangleMesh& mesh, uint32_t vertex, size_t side, FanCorner& at) {
  const auto& faces = mesh.edge_faces[mesh.triangle_edges[at.triangle][side]];
  const uint32_t other = faces[0] == at.triangle ? faces[1] : faces[0];
  for (size_t i = 0; other != kNoFace && i < 3; ++i) {
    if (mesh.triangles[other][i] != vertex) continue;
    at = {other, i};
    return true;
  }
  return false;
}

}  // namespace

VertexFan::VertexFan(const TriangleMesh& mesh, uint32_t triangle, size_t corner) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size() && corner < 3);
  const uint32_t vertex = mesh.triangles[triangle][corner];
  vertex_O_ = mesh.vertices[vertex];
  // back to the border, if there is one
  FanCorner at{triangle, corner};
  for (size_t i = 0; i < kMaxTriangles && turn(mesh, vertex, at.corner, at); ++i) {
    if (at.triangle == triangle) break;
  }
  const uint32_t first = at.triangle;
  do {
    add(mesh, at.triangle, at.corner);
  } while (size_ < kMaxTriangles && turn(mesh, vertex, (at.corner + 2) % 3, at) &&
           at.triangle != first);
}

void VertexFan::add(const TriangleMesh& mesh, uint32_t triangle, size_t corner) {
  HAPTIC_ASSERT(size_ < kMaxTriangles);
  const Triangle& corners = mesh.triangles[triangle];
  const Triangle& edges = mesh.triangle_edges[triangle];
  const size_t next = (corner + 1) % 3, last = (corner + 2) % 3;
  const auto along = [&](size_t i) { return normalized(mesh.vertices[corners[i]] - vertex_O_); };
  sectors_[size_++] = {along(next), along(last), mesh.edge_normals[edges[corner]],
                       mesh.edge_normals[edges[last]], mesh.face_normals[triangle]};
}

WayFromVertex VertexFan::steepest(const Vec3& goal_O, double below) const {
  WayFromVertex best;
  const auto offer = [&](size_t place, const Vec3& direction_O, const Vec3& outward_O) {
    const double reach = dot(goal_O, direction_O);
    if (reach > best.reach && reach < below) best = {true, reach, place, direction_O, outward_O};
  };
  for (size_t i = 0; i < size_; ++i) {
    const Sector& s = sectors_[i];
    offer(2 * i, s.first_O, s.edge_normal_O);
    // the last edge of an open fan begins no triangle
    offer(2 * i + 1, s.last_O, s.last_edge_normal_O);
    const Vec3 along_O = goal_O - dot(goal_O, s.normal_O) * s.normal_O;
    const bool is_between = dot(cross(s.first_O, along_O), s.normal_O) > 0 &&
                            dot(cross(along_O, s.last_O), s.normal_O) > 0;
    if (is_between) offer(2 * i + 1, normalized(along_O), s.normal_O);
  }
  return best;
}

Vec3 VertexFan::at(size_t place, double around) const {
  HAPTIC_ASSERT(place < places());
  const Sector& s = sectors_[place / 2];
  const bool is_edge = place % 2 == 0;
  const Vec3 direction_O = is_edge ? s.first_O : normalized(s.first_O + s.last_O);
  const Vec3& outward_O = is_edge ? s.edge_normal_O : s.normal_O;
  return vertex_O_ + around * (direction_O + kOver * outward_O);
}

Vec3 VertexFan::at(const WayFromVertex& way, double around) const {
  return vertex_O_ + around * (way.direction_O + kOver * way.outward_O);
}

}  // namespace haptic
