// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/math/vec3.h"

namespace haptic {

/// A plane normal · p = offset.
struct Plane {
  Vec3 normal;        // unit
  double offset = 0;  // [m]

  double above(const Vec3& p) const { return dot(normal, p) - offset; }
};

/// The plane of three points, counter-clockwise as seen from above.
inline Plane plane_through(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = normalized(cross(b - a, c - a));
  return {normal, dot(normal, a)};
}

/// A convex hull that grows point by point (Kallay 1984), with exact orientations, so that what a
/// point sees of it is always one disc. Its faces are triangles; coplanar ones stay apart.
class GrowingHull {
 public:
  /// What the hull gains by a point: the tetrahedron of that point and a face which it sees.
  struct Gain {
    std::array<Vec3, 3> face;        // counter-clockwise as seen from the point
    std::array<bool, 3> is_outer{};  // side i, from corner i: the face there remains
  };

  /// Begins anew with a tetrahedron; `apex` lies behind the triangle.
  void begin(const std::array<Vec3, 3>& triangle, const Vec3& apex);

  /// What the hull would gain by this point; nothing: the point lies in it. Valid until the next
  /// call of any member.
  const std::vector<Gain>& gains(const Vec3& p);

  /// The planes that this point would add, and those of the faces beside them.
  const std::vector<Plane>& planes_around() const { return planes_around_; }

  /// Calls f with the plane of each face that this point does not see, until f returns false.
  /// Whether it never did.
  template <class F>
  bool all_unseen(F&& f) const {
    for (const Face& face : faces_) {
      if (!face.is_gone && face.seen != question_ && !f(face.plane)) return false;
    }
    return true;
  }

  /// Adds the point of the last call of gains.
  void add();

 private:
  struct Face {
    std::array<Vec3, 3> p;
    Plane plane;
    std::array<uint32_t, 3> neighbour;  // across side i, from corner i to the next
    uint32_t seen = 0;                  // by the question of this number
    bool is_gone = false;
  };
  static Face make_face(const std::array<Vec3, 3>& p, const std::array<uint32_t, 3>& neighbour);
  bool sees(const Face& face) const;

  std::vector<Face> faces_;
  uint32_t question_ = 0;
  Vec3 point_;
  std::vector<uint32_t> visible_;
  std::vector<Gain> gains_;
  std::vector<Plane> planes_around_;
};

}  // namespace haptic
