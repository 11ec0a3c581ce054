// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <catch2/catch.hpp>
#include <span>

#include "contact/shape/mesh/primitives.h"
#include "tests/support/cgal_pairs.h"

namespace haptic::test {

/// Signed volume by the divergence theorem.
inline double volume(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    sum += dot(vertices[a], cross(vertices[b], vertices[c])) / 6;
  }
  return sum;
}
inline double volume(const Soup& soup) {
  return volume(soup.vertices, soup.triangles);
}

/// A solid without self-intersections, by CGAL.
inline void check_solid(const Soup& soup) {
  const CgalSurface surface = cgal_surface(soup.vertices, soup.triangles);
  CHECK(surface.is_manifold);
  CHECK(surface.is_closed);
  CHECK(surface.faces_out);
  CHECK(surface.self_intersections == 0);
}

}  // namespace haptic::test
