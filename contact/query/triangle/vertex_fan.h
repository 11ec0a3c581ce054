// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A way along the surface that leaves a vertex: in one of its triangles, or on one of its edges.
struct WayFromVertex {
  bool found = false;
  double reach = 0;  // how far the goal lies that way: goal · direction [m]
  size_t place = 0;  // where around the vertex it begins
  Vec3 direction_O, outward_O;
};

/// The triangles around a vertex, in order, on the stack. What is free around a vertex is a cone
/// bounded by them, convex or not.
///
/// Places around the vertex are numbered in the same order: 2i is over the edge with which triangle
/// i begins, 2i + 1 over the triangle. They lie in front of the surface next to them; whether
/// anything else is in the way from one to the next is for the caller to ask.
class VertexFan {
 public:
  /// Of corner `corner` of a triangle; of more than 64 triangles only some.
  VertexFan(const TriangleMesh& mesh, uint32_t triangle, size_t corner);

  /// The steepest way towards a goal, goal_O from the vertex, of those with a reach below `below`
  /// [m]. In a cone from whose apex the goal is not seen, the steepest way lies on the boundary: in
  /// a triangle it is the projection of the goal, else an edge. So the vertex is a local minimum of
  /// the distance to a goal that it hides exactly where there is no way.
  WayFromVertex steepest(const Vec3& goal_O,
                         double below = std::numeric_limits<double>::infinity()) const;

  size_t places() const { return 2 * size_; }
  /// `around` away from the vertex, and over the surface by a small part of that [m].
  Vec3 at(size_t place, double around) const;
  /// The same where a way begins.
  Vec3 at(const WayFromVertex& way, double around) const;

 private:
  static constexpr size_t kMaxTriangles = 64;  // ten times as many as a vertex has on average
  struct Sector {
    Vec3 first_O, last_O;  // along its edges at the vertex, unit
    Vec3 edge_normal_O;    // pseudo-normal of the first
    Vec3 last_edge_normal_O;
    Vec3 normal_O;
  };
  void add(const TriangleMesh& mesh, uint32_t triangle, size_t corner);

  Vec3 vertex_O_;
  std::array<Sector, kMaxTriangles> sectors_;
  size_t size_ = 0;
};

}  // namespace haptic
