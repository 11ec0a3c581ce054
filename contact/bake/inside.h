// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Exact point-in-mesh test by CGAL's filtered predicates, independent of our own queries: verifies
/// that the proxy is never inside. Closed, manifold meshes only: else throws MeshError.
class InsideOracle {
 public:
  explicit InsideOracle(const TriangleMesh& mesh);
  ~InsideOracle();
  InsideOracle(const InsideOracle&) = delete;
  InsideOracle& operator=(const InsideOracle&) = delete;

  /// True strictly inside, false outside or on the surface.
  bool inside(const Vec3& p_O) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace haptic
