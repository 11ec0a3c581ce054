// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

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

/// A convex polyhedron in the frame of its object; views. Where a piece is flat, its two sides are
/// faces with opposite normals.
struct Hull {
  std::span<const Vec3> vertices;
  std::span<const HullEdge> edges;
  std::span<const HullFace> faces;
  std::span<const uint32_t> edge_from;  // of each vertex: one half-edge that leaves it
};

}  // namespace haptic
