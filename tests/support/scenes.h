// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "contact/detect/point/point_proxy.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic::test {

/// Objects at their poses, for the detector alone.
struct TestScene {
  std::vector<MeshShapeData> owned;
  std::vector<MeshShape> shapes;
  PointScene scene;

  void add(Soup soup, const Pose& X_WO = {}) {
    owned.push_back(build_shape(std::move(soup)));
    scene.X_WO.push_back(X_WO);
    shapes.push_back(owned.back().view());
    scene.shapes = shapes;
  }
};

/// The same surface with reversed orientation: a room instead of a block.
inline Soup turned_inside_out(Soup soup) {
  for (Triangle& t : soup.triangles) std::swap(t[1], t[2]);
  return soup;
}

/// Prism of a polygon (counter-clockwise, seen from +z) from z = −half to +half; convex fan caps.
inline Soup make_prism(const std::vector<Vec3>& outline, double half) {
  Soup soup;
  const auto n = static_cast<uint32_t>(outline.size());
  for (const double z : {-half, half}) {
    for (const Vec3& p : outline) soup.vertices.push_back({p.x, p.y, z});
  }
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    soup.triangles.push_back({i, j, n + j});
    soup.triangles.push_back({i, n + j, n + i});
  }
  for (uint32_t i = 1; i + 1 < n; ++i) {
    soup.triangles.push_back({0, i + 1, i});
    soup.triangles.push_back({n, n + i, n + i + 1});
  }
  return soup;
}

}  // namespace haptic::test
