// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "contact/shape/mesh/arrays.h"
#include "proto/math/pose.h"

namespace haptic {

using Triangle = std::array<uint32_t, 3>;  // vertices, counter-clockwise seen from outside
using Corners = std::array<Vec3, 3>;       // of a triangle, in the same order
inline constexpr uint32_t kNoFace = ~0u;   // second face of a border edge

/// Indexed triangle mesh in its object frame O [m]. Normals are unit vectors, outward.
template <template <class> class Array>
struct TriangleMeshOf {
  Array<Vec3> vertices;
  Array<Triangle> triangles;
  Array<Vec3> face_normals;
  Array<Triangle> triangle_edges;             // edge i joins vertices i and (i+1)%3
  Array<std::array<uint32_t, 2>> edge_faces;  // second is kNoFace on a border
  Array<uint32_t> vertex_valence;             // triangles around each vertex
  // angle-weighted pseudo-normals: their sign tells inside from outside (Bærentzen & Aanæs 2005)
  Array<Vec3> edge_normals;
  Array<Vec3> vertex_normals;
  Vec3 lower, upper;  // bounding box
  bool closed = false;

  TriangleMeshOf<ArrayView> view() const {
    return {vertices,     triangles,      face_normals, triangle_edges, edge_faces, vertex_valence,
            edge_normals, vertex_normals, lower,        upper,          closed};
  }
};
using TriangleMesh = TriangleMeshOf<ArrayView>;
using MeshData = TriangleMeshOf<ArrayData>;

inline Corners corners_of(const TriangleMesh& mesh, uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

/// The corners of a triangle of B moved to A; each vertex is rounded once, so that neighbouring
/// triangles still share corners.
inline Corners corners_of(const TriangleMesh& mesh, uint32_t triangle, const Pose& X_AB) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {X_AB * mesh.vertices[a], X_AB * mesh.vertices[b], X_AB * mesh.vertices[c]};
}

/// The triangle beyond a side; kNoFace: the side is a border.
inline uint32_t neighbour_across(const TriangleMesh& mesh, uint32_t triangle, size_t side) {
  const auto& [left, right] = mesh.edge_faces[mesh.triangle_edges[triangle][side]];
  return left == triangle ? right : left;
}

}  // namespace haptic
