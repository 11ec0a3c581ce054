// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/eval/oracle/facets.h"

namespace haptic {

/// What the exact god-object answers to one position of the tool.
struct OracleAnswer {
  Vec3 proxy_O;           // on the surface, or the tool itself where it is free
  int n_active = 0;       // obstacles that push: 0 free, 1, 2 or 3
  bool converged = true;  // false: out of sweeps, or obstacles without a solution
  int sweeps = 0;
};

/// The god-object of Zilles & Salisbury 1995 by brute force: no tree, no look-ahead, no cache. It
/// slides towards the tool along straight sweeps, stopped 1e-12 m in front of the first of all
/// facets it would enter; where it stands, the next goal is the exact minimum of |x − tool| over
/// the planes that stopped it there (every subset of up to three is tried). The answer is on the
/// planes themselves. Only the mesh is shared with the detector that it judges.
///
/// Facets are looked up in bins, without loss: each sweep ends nearer to the tool than it began, so
/// the whole way lies in the ball around the tool through the old proxy, and every facet that meets
/// this ball is tested. The facets must outlive the oracle; they lie at rest.
class GodObjectOracle {
 public:
  explicit GodObjectOracle(const FacetBins& facets) : facets_(facets) {}

  /// Places the god-object at a point, taken for free.
  void seed(const Vec3& p_O);

  /// Follows the tool to tool_O.
  OracleAnswer follow(const Vec3& tool_O);

 private:
  struct Stop {
    const Facet* facet = nullptr;
    long double t = 1;
  };
  Stop first_stop(const Long3& from, const Long3& to) const;

  const FacetBins& facets_;
  std::vector<uint32_t> near_;  // facets of the present ball
  Long3 g_;
};

}  // namespace haptic
