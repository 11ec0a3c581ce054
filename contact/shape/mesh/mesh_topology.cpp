// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/mesh/mesh_topology.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Side `corner` of a face, sortable by the undirected edge it lies on.
struct Side {
  uint32_t low, high;  // vertices of the edge
  uint32_t face;
  uint8_t corner;
  bool forward;  // runs from low to high
};

std::vector<Side> sorted_sides(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (uint32_t f = 0; f < triangles.size(); ++f) {
    for (uint8_t i = 0; i < 3; ++i) {
      const uint32_t a = triangles[f][i], b = triangles[f][(i + 1u) % 3u];
      sides.push_back({std::min(a, b), std::max(a, b), f, i, a < b});
    }
  }
  const auto key = [](const Side& s) { return std::pair(uint64_t{s.low} << 32 | s.high, s.face); };
  std::sort(sides.begin(), sides.end(),
            [&](const Side& a, const Side& b) { return key(a) < key(b); });
  return sides;
}

/// Adds the edge of side a and of its partner b, if there is one.
void add_edge(MeshData& mesh, const Side& a, const Side* b) {
  const auto edge = static_cast<uint32_t>(mesh.edge_faces.size());
  mesh.edge_faces.push_back({a.face, b != nullptr ? b->face : kNoFace});
  mesh.triangle_edges[a.face][a.corner] = edge;
  if (b != nullptr) mesh.triangle_edges[b->face][b->corner] = edge;
  mesh.closed = mesh.closed && b != nullptr;
}

void build_edges(MeshData& mesh) {
  mesh.triangle_edges.resize(mesh.triangles.size());
  mesh.edge_faces.reserve(3 * mesh.triangles.size() / 2);
  mesh.closed = !mesh.triangles.empty();
  const std::vector<Side> sides = sorted_sides(mesh.triangles);
  std::vector<const Side*> forward, backward;
  for (size_t i = 0; i < sides.size();) {
    // all sides with the same two vertices: two in a manifold mesh
    forward.clear();
    backward.clear();
    size_t end = i;
    for (; end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high;
         ++end) {
      (sides[end].forward ? forward : backward).push_back(&sides[end]);
    }
    const size_t pairs = std::min(forward.size(), backward.size());
    for (size_t k = 0; k < pairs; ++k) add_edge(mesh, *forward[k], backward[k]);
    for (size_t k = pairs; k < forward.size(); ++k) add_edge(mesh, *forward[k], nullptr);
    for (size_t k = pairs; k < backward.size(); ++k) add_edge(mesh, *backward[k], nullptr);
    i = end;
  }
}

double corner_angle(const Vec3& at, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - at, v = c - at;
  return std::atan2(norm(cross(u, v)), dot(u, v));
}

void build_normals(MeshData& mesh) {
  const size_t n_faces = mesh.triangles.size();
  mesh.face_normals.resize(n_faces);
  mesh.vertex_normals.assign(mesh.vertices.size(), Vec3{});
  mesh.vertex_valence.assign(mesh.vertices.size(), 0);
  for (size_t f = 0; f < n_faces; ++f) {
    const Triangle& tri = mesh.triangles[f];
    const Vec3 p[3] = {mesh.vertices[tri[0]], mesh.vertices[tri[1]], mesh.vertices[tri[2]]};
    mesh.face_normals[f] = normalized(cross(p[1] - p[0], p[2] - p[0]));
    for (size_t i = 0; i < 3; ++i) {
      ++mesh.vertex_valence[tri[i]];
      mesh.vertex_normals[tri[i]] +=
          corner_angle(p[i], p[(i + 1) % 3], p[(i + 2) % 3]) * mesh.face_normals[f];
    }
  }
  for (Vec3& normal : mesh.vertex_normals) normal = normalized(normal);

  mesh.edge_normals.resize(mesh.edge_faces.size());
  for (size_t e = 0; e < mesh.edge_faces.size(); ++e) {
    const auto [left, right] = mesh.edge_faces[e];
    const Vec3& n_left = mesh.face_normals[left];
    const Vec3 sum = right == kNoFace ? n_left : n_left + mesh.face_normals[right];
    // two faces folded onto each other have no mean direction: choose one
    mesh.edge_normals[e] = norm_squared(sum) > 0 ? normalized(sum) : n_left;
  }
}

}  // namespace

MeshData build_mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles) {
  HAPTIC_ASSERT(std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    return std::max({t[0], t[1], t[2]}) < vertices.size();
  }));
  MeshData mesh;
  mesh.vertices = std::move(vertices);
  mesh.triangles = std::move(triangles);
  build_edges(mesh);
  build_normals(mesh);
  if (!mesh.vertices.empty()) {
    const Box box = box_around(mesh.vertices);
    mesh.lower = box.lower;
    mesh.upper = box.upper;
  }
  return mesh;
}

std::vector<Vec3> points_of_shells(const TriangleMesh& mesh) {
  std::vector<Vec3> points;
  std::vector<bool> is_known(mesh.triangles.size());
  std::vector<uint32_t> waiting;
  const auto note = [&](uint32_t face) {
    if (face == kNoFace || is_known[face]) return false;
    is_known[face] = true;
    waiting.push_back(face);
    return true;
  };
  for (uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    if (note(f)) points.push_back(mesh.vertices[mesh.triangles[f][0]]);
    while (!waiting.empty()) {
      const uint32_t face = waiting.back();
      waiting.pop_back();
      for (const uint32_t edge : mesh.triangle_edges[face]) {
        for (const uint32_t neighbour : mesh.edge_faces[edge]) note(neighbour);
      }
    }
  }
  return points;
}

}  // namespace haptic
