// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/triangle_mesh.h"

namespace haptic {

/// Extended precision, so that the oracle's rounding is a thousandth of what it judges.
struct Long3 {
  long double x = 0, y = 0, z = 0;
};

/// What the exact god-object answers to one position of the tool.
struct OracleAnswer {
  Vec3 proxy_O;           // on the surface, or the tool itself where it is free
  int n_active = 0;       // facets that push: 0 free, 1 face, 2 edge, 3 vertex
  bool converged = true;  // false: more than kOracleSweeps sweeps, or facets without a solution
  int sweeps = 0;
};

/// How far a point is behind the surface, by the nearest of all its facets.
struct BehindSurface {
  double depth = 0;       // [m]; 0: in front
  bool is_known = false;  // false: no facet within the distance asked, or the nearest is a border
};

/// The god-object of Zilles & Salisbury 1995 by brute force: no tree, no look-ahead, no cache. It
/// slides towards the tool along straight sweeps, stopped 1e-12 m in front of the first of all
/// facets it would enter; where it stands, the next goal is the exact minimum of |x − tool| over
/// the planes that stopped it there (every subset of up to three is tried). The answer is on the
/// planes themselves. Only the mesh is shared with the detector that it judges.
///
/// Facets are looked up in bins, without loss: each sweep ends nearer to the tool than it began, so
/// the whole way lies in the ball around the tool through the old proxy, and every facet that meets
/// this ball is tested. The arrays of the mesh must outlive the oracle; it lies at rest.
class GodObjectOracle {
 public:
  explicit GodObjectOracle(const TriangleMesh& mesh);

  /// Places the god-object at a point, taken for free.
  void seed(const Vec3& p_O);

  /// Follows the tool to tool_O.
  OracleAnswer follow(const Vec3& tool_O);

  /// Whether a point is behind the facet nearest to it, within max_distance (all facets; side by
  /// angle-weighted normals).
  BehindSurface behind(const Vec3& p_O, double max_distance);

 private:
  struct Facet {
    Long3 a, b, c, normal;  // unit, zero where the facet has no area
    Vec3 middle_O;
    double reach = 0;  // from the middle to the farthest corner [m]
  };
  struct Stop {
    const Facet* facet = nullptr;
    long double t = 1;
  };
  void gather(const Vec3& centre_O, double radius);
  size_t bin_along(int axis, double coordinate) const;
  Stop first_stop(const Long3& from, const Long3& to) const;

  TriangleMesh mesh_;
  std::vector<Facet> facets_;
  double reach_ = 0;  // of the largest facet
  Vec3 lower_;
  std::array<size_t, 3> bins_{1, 1, 1};
  double bin_ = 1;  // edge [m]
  std::vector<uint32_t> first_in_bin_, order_;
  std::vector<uint32_t> near_;  // facets of the present ball
  Long3 g_;
};

}  // namespace haptic
