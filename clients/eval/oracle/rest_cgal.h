// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A straight way that a proxy at rest could still go.
struct FoundWay {
  bool found = false;
  Vec3 end_O;
  double gain = 0;  // |proxy − tool| − |end − tool| [m]
};

/// Judges places of rest of a point on a closed mesh that does not cut itself, by ways taken at
/// random: it knows neither planes nor paths. Which segments meet the surface and which points lie
/// inside it is answered by CGAL's exact predicates; the renderers have no part in it.
class WayJudge {
 public:
  explicit WayJudge(const TriangleMesh& mesh);
  ~WayJudge();

  /// Whether a point lies inside the mesh or on it.
  bool holds(const Vec3& p_O) const;

  /// Whether the segment begins outside and meets no triangle.
  bool is_free(const Vec3& from_O, const Vec3& to_O) const;

  /// The best of so many straight ways from the proxy, in directions that near the tool, of 10 µm
  /// to 3 mm, that is free but for its first nanometre, in which the roundings of the proxy are,
  /// and gains more than `least` [m]. The same directions for the same seed.
  FoundWay free_way(const Vec3& proxy_O, const Vec3& tool_O, double least, int directions,
                    uint64_t seed) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace haptic
