// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Checks rest positions of a point on a closed mesh without self-intersections by random segments:
/// independent of planes and paths. Which segments meet the surface and which points lie inside is
/// decided by CGAL's exact predicates; no code is shared with the renderers.
class WayJudge {
 public:
  explicit WayJudge(const TriangleMesh& mesh);
  ~WayJudge();

  /// True if a point lies inside the mesh or on its surface.
  bool holds(const Vec3& p_O) const;

  /// True if the segment begins outside and meets no triangle.
  bool is_free(const Vec3& from_O, const Vec3& to_O) const;

  /// The gain |proxy − tool| − |end − tool| of the best of `directions` random directions from the
  /// proxy towards the tool [m]: of a free segment of 10 µm to 3 mm that gains more than `least`
  /// [m]; nothing if there is none. Its first nanometre is not tested, to allow
  /// for the proxy's rounding. Equal seeds give equal directions.
  std::optional<double> free_way(const Vec3& proxy_O, const Vec3& tool_O, double least,
                                 int directions, uint64_t seed) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace haptic
