// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A direction along the surface from a vertex: in one of its triangles, or along one of its edges.
struct WayFromVertex {
  bool found = false;
  double reach = 0;  // progress towards the goal: goal · direction [m]
  size_t place = 0;  // index of the place where it begins
  Vec3 direction_O, outward_O;
};

/// The triangles around a vertex, in order, on the stack. The free space around a vertex is a cone
/// that they bound, convex or not.
///
/// Places around the vertex are numbered in the same order: 2i is over the first edge of triangle
/// i, 2i + 1 over the triangle. They lie in front of the adjacent surface; the caller must test
/// whether anything else is between one and the next.
class VertexFan {
 public:
  /// Around corner `corner` of a triangle; of more than 64 triangles only some.
  VertexFan(const TriangleMesh& mesh, uint32_t triangle, size_t corner);

  /// The steepest direction towards a goal, goal_O from the vertex, of those with a reach below
  /// `below` [m]. In a cone whose apex does not see the goal, the steepest direction lies on the
  /// boundary: in a triangle it is the projection of the goal, else an edge. So the vertex is a
  /// local minimum of the distance to a goal that it hides if and only if there is no such
  /// direction.
  WayFromVertex steepest(const Vec3& goal_O,
                         double below = std::numeric_limits<double>::infinity()) const;

  size_t places() const { return 2 * size_; }
  /// A point `around` from the vertex, raised above the surface by a small part of that [m].
  Vec3 at(size_t place, double around) const;
  /// Such a point at the start of a direction.
  Vec3 at(const WayFromVertex& way, double around) const;

 private:
  static constexpr size_t kMaxTriangles = 64;  // ten times the average of a vertex
  struct Sector {
    Vec3 first_O, last_O;  // along its edges at the vertex, unit
    Vec3 edge_normal_O;    // pseudo-normal of the first edge
    Vec3 last_edge_normal_O;
    Vec3 normal_O;
  };
  void add(const TriangleMesh& mesh, uint32_t triangle, size_t corner);

  Vec3 vertex_O_;
  std::array<Sector, kMaxTriangles> sectors_;
  size_t size_ = 0;
};

}  // namespace haptic
