// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "clients/lab/eval/oracle/long3.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A triangle in extended precision, as used by the oracles.
struct Facet {
  Long3 a, b, c, normal;  // normal: unit, zero for a facet without area
  Vec3 middle_O;
  double reach = 0;  // radius of the bounding ball around middle_O [m]
};

/// All facets of a mesh in bins: brute force for checking trees and grids. The arrays of the mesh
/// must outlive it.
class FacetBins {
 public:
  explicit FacetBins(const TriangleMesh& mesh);

  const Facet& operator[](uint32_t triangle) const { return facets_[triangle]; }
  const TriangleMesh& mesh() const { return mesh_; }

  /// Every facet whose bounding ball meets the given ball: all that meet it, and some more.
  std::vector<uint32_t> within(const Vec3& centre_O, double radius) const;

 private:
  size_t bin_along(int axis, double coordinate) const;

  TriangleMesh mesh_;
  std::vector<Facet> facets_;
  double reach_ = 0;  // largest of all facets [m]
  std::array<size_t, 3> bins_{1, 1, 1};
  double bin_ = 1;  // edge of a bin [m]
  std::vector<uint32_t> first_in_bin_, order_;
};

}  // namespace haptic
