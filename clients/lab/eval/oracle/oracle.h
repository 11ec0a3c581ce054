// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "clients/lab/eval/oracle/facets.h"
#include "clients/lab/eval/oracle/walls.h"

namespace haptic {

/// Answer of an exact proxy to one position of the tool.
struct OracleAnswer {
  Vec3 proxy_O;           // on the surface, or the tool itself if it is free
  int n_active = 0;       // size of the active set: 0 (free), 1, 2 or 3
  bool converged = true;  // false: sweep limit reached, or no feasible point
  bool has_left = false;  // it took a way away from a vertex that is neither convex nor concave
  int sweeps = 0;
};

/// A proxy by brute force over all facets, which do not move and must outlive it.
class ProxyOracle {
 public:
  explicit ProxyOracle(const FacetBins& facets) : facets_(facets) {}
  virtual ~ProxyOracle() = default;

  /// Places the proxy at a point that is assumed to be free.
  void seed(const Vec3& p_O) { g_ = widened<long double>(p_O); }
  /// Moves the proxy for a tool at tool_O.
  virtual OracleAnswer follow(const Vec3& tool_O) = 0;

 protected:
  /// Ends an answer where the sweeps end, or on the surface itself if there is a minimum.
  OracleAnswer& place(OracleAnswer& answer, const std::optional<NearestInWalls>& on_surface) const;

  const FacetBins& facets_;
  std::vector<uint32_t> near_;  // facets of the current ball
  Long3 g_;
};

/// The oracle of a sphere, or of a point where the radius is 0.
std::unique_ptr<ProxyOracle> make_oracle(const FacetBins& facets, double radius);

/// The god-object of Zilles & Salisbury 1995 by brute force: no tree, no look-ahead, no cache. It
/// slides towards the tool along straight sweeps and stops 1e-12 m before the first of all facets
/// it would enter; there, the next goal is the exact minimum of |x − tool| over the planes that
/// stopped it (every subset of up to three is tried). The answer lies on the planes themselves. At
/// a vertex that is neither convex nor concave the free space is no intersection of half-spaces,
/// and those of all its facets may hold where a way along one or two of them is free: of these ways
/// it takes the steepest. It shares only the mesh with the detector under test.
///
/// Looking facets up in bins loses none: each sweep ends nearer to the tool than it began, so the
/// whole path lies in the ball around the tool through the old proxy, and every facet that meets
/// this ball is tested.
class GodObjectOracle : public ProxyOracle {
 public:
  using ProxyOracle::ProxyOracle;
  OracleAnswer follow(const Vec3& tool_O) override;

 private:
  struct Stop {
    const Facet* facet = nullptr;
    long double t = 1;
  };
  Stop first_stop(const Long3& from, const Long3& to) const;
  Long3 reached_towards(const Long3& goal, const Stop& stop) const;
  std::optional<NearestInWalls> nearest_on(const std::vector<const Facet*>& planes,
                                           const Long3& tool, long double stand_off) const;
  std::vector<const Facet*> touched() const;
  bool leave(const Long3& tool);
};

}  // namespace haptic
