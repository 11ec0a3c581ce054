// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "clients/lab/eval/oracle/oracle.h"
#include "clients/lab/eval/oracle/walls.h"

namespace haptic {

/// The virtual proxy of Ruspini, Kolarov & Khatib 1997 by brute force: a sphere whose centre may be
/// wherever no facet is nearer than the radius. The obstacles of a facet are its offset face, edge
/// cylinders and vertex spheres. It slides like GodObjectOracle, along straight sweeps and tangent
/// planes, and rolls around an edge in as many small steps as it takes, to a local minimum of
/// |x − tool|. There Newton's method on the at most three obstacles that push solves
/// x − tool = Σ λ_i ∇d_i, d_i = radius to the last digits. A solution is accepted only if every
/// λ_i > 0, no facet is nearer than the radius and the second-order condition holds.
///
/// It shares neither the trees, the one-sided surfaces nor the steps around bends with the
/// detector.
class SphereOracle : public ProxyOracle {
 public:
  /// radius > 0 [m].
  SphereOracle(const FacetBins& facets, double radius);

  OracleAnswer follow(const Vec3& tool_O) override;

  /// An obstacle of the centre: the offset of a facet's plane, line or point.
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
  /// End of a sweep from here to the goal, a stand-off before the obstacle.
  Long3 swept_to(const Stop& stop, const Long3& goal) const;
  /// Exact minimum of |x − tool| over the tangent planes of `stops`, relative to the present place.
  std::optional<NearestInWalls> minimum_over(std::span<const Obstacle> stops, const Long3& tool,
                                             long double stand_off) const;

  long double radius_;
  std::vector<uint8_t> owned_;   // bit i: edge i, bit 3 + i: vertex i; each is in one facet
  mutable uint32_t recent_ = 0;  // the facet that stopped it last, tested first
};

}  // namespace haptic
