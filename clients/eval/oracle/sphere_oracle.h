// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "clients/eval/oracle/oracle.h"
#include "clients/eval/oracle/walls.h"

namespace haptic {

/// The virtual proxy of Ruspini, Kolarov & Khatib 1997 by brute force: a sphere whose centre may be
/// wherever no facet is nearer than the radius. From each facet it is kept by an offset face, edge
/// cylinders and vertex spheres. It slides as GodObjectOracle does, along straight sweeps and
/// tangent planes, rolls around an edge in as many small legs as it takes, and comes to rest in a
/// local minimum of |x − tool|; there Newton's method on the at most three obstacles that push
/// solves x − tool = Σ λ_i ∇d_i, d_i = radius to the last digits. A solution counts only where
/// every λ_i > 0, no facet is nearer than the radius and the minimum is one to second order too.
///
/// Neither the trees, the one-sided surfaces nor the leaps around bends of the detector are shared.
/// The facets must outlive the oracle; they lie at rest.
class SphereOracle {
 public:
  /// radius > 0 [m].
  SphereOracle(const FacetBins& facets, double radius);

  /// Places the centre at a point, taken for free.
  void seed(const Vec3& p_O);

  /// Follows the tool to tool_O.
  OracleAnswer follow(const Vec3& tool_O);

  /// What keeps the sphere away: a plane, a line or a point, which is a part of a facet.
  struct Obstacle {
    enum class Kind { kFace, kEdge, kVertex } kind = Kind::kFace;
    Long3 point;
    Long3 direction;  // normal of the face, or along the edge; unit
    uint32_t triangle = 0;
  };

 private:
  struct Stop {
    std::optional<Obstacle> obstacle;
    long double t = 1;
  };
  Stop first_stop(const Long3& from, const Long3& to) const;
  void stop_at_facet(uint32_t triangle, const Long3& from, const Long3& d, Stop& first) const;
  std::optional<Long3> rest_on(std::span<const Obstacle> pushing, const Long3& from,
                               const Long3& tool) const;
  bool has_room(const Long3& x) const;
  /// Where a sweep from here to the goal ends, a stand-off in front of what stops it.
  Long3 swept_to(const Stop& stop, const Long3& goal) const;
  /// The way to the exact minimum of |x − tool| over the tangent planes here of what stopped it.
  std::optional<NearestInWalls> minimum_over(std::span<const Obstacle> stops, const Long3& tool,
                                             long double stand_off) const;

  const FacetBins& facets_;
  long double radius_;
  std::vector<uint8_t> owned_;   // bit i: edge i, bit 3 + i: vertex i; each belongs to one facet
  std::vector<uint32_t> near_;   // facets of the present ball
  mutable uint32_t recent_ = 0;  // the facet that stopped it last, tried first
  Long3 g_;
};

}  // namespace haptic
