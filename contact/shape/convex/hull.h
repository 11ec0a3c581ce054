// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/shape/mesh/arrays.h"
#include "proto/math/vec3.h"

namespace haptic {

/// A half-edge of a convex polyhedron. Those of a face are consecutive, counter-clockwise as seen
/// from outside.
struct HullEdge {
  uint32_t from;  // vertex
  uint32_t twin;  // half-edge of the neighbouring face
  uint32_t next;  // half-edge of the same face
  uint32_t face;
};

/// A face of a convex polyhedron: a planar polygon, coplanar triangles merged, with
/// normal · p = offset.
struct HullFace {
  Vec3 normal;    // unit, outward
  double offset;  // [m]
  uint32_t first_edge;
  uint32_t n_edges;
  uint32_t is_virtual;  // 1: it closes the piece and is no part of the object's surface
  uint32_t triangle;    // of the object's mesh that lies in it, the lowest; virtual: kNoTriangle
};

inline constexpr uint32_t kNoTriangle = 0xffffffff;

/// A convex polyhedron in the frame of its object. Where a piece is flat, its two sides are faces
/// with opposite normals.
template <template <class> class Array>
struct HullOf {
  Array<Vec3> vertices;
  Array<HullEdge> edges;
  Array<HullFace> faces;
  Array<uint32_t> edge_from;  // of each vertex: one half-edge that leaves it

  HullOf<ArrayView> view() const { return {vertices, edges, faces, edge_from}; }
};
using Hull = HullOf<ArrayView>;
using HullData = HullOf<ArrayData>;

/// The vertex at which a half-edge ends.
inline uint32_t end_vertex(const Hull& hull, uint32_t edge) {
  return hull.edges[hull.edges[edge].twin].from;
}

/// The half-edge that leaves the same vertex next, clockwise seen from outside.
inline uint32_t next_around(const Hull& hull, uint32_t edge) {
  return hull.edges[hull.edges[edge].twin].next;
}

/// Calls f with each half-edge that leaves a vertex.
template <class F>
void for_edges_around(const Hull& hull, uint32_t vertex, F&& f) {
  const uint32_t first = hull.edge_from[vertex];
  uint32_t edge = first;
  do {
    f(edge);
    edge = next_around(hull, edge);
  } while (edge != first);
}

/// A vertex that is farthest along a direction (of any length but 0): from the vertex `start` to a
/// neighbour that is farther, until there is none. On a convex polyhedron that is a farthest one.
uint32_t support_vertex(const Hull& hull, const Vec3& direction, uint32_t start);

/// Says for people where the links of a hull are wrong; null where they are sound: indices within
/// their arrays, twins and cycles that belong together, Euler's V − E + F = 2, at least three edges
/// around each face. O(edges): at start-up.
const char* hull_links_defect(const Hull& hull);

/// Says for people what is wrong with a hull; null where it is sound: hull_links_defect, unit
/// normals, each vertex of a face within the tolerance of its plane, and no vertex beyond any plane
/// by more than the tolerance [m]. O(vertices · faces): in tests.
const char* hull_defect(const Hull& hull, double tolerance);

}  // namespace haptic
