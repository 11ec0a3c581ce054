// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/penetration_depth.h"

#include <algorithm>
#include <cmath>

#include "contact/query/convex/expanding_polytope.h"
#include "contact/query/convex/overlay_descent.h"
#include "contact/query/convex/touching_point.h"

namespace haptic {
namespace {

constexpr uint32_t kLookElsewhere = 256;  // queries: 0.4 % of them also look elsewhere
// depths that differ by more are different minima, in shares of the depth: above rounding
constexpr double kSameDepth = 1e-9;

Vec3 centroid_of(const Hull& hull) {
  Vec3 sum;
  for (const Vec3& p : hull.vertices) sum += p;
  return sum / static_cast<double>(hull.vertices.size());
}

/// The starts of one query, and the best of what they found.
struct DepthSearch {
  const HullPair& pair;
  GaussOverlay overlay;
  OverlayDescent descent;
  OverlayVertex best = {};
  bool has_best = false, suspect = false;
  int n_steps = 0;

  explicit DepthSearch(const HullPair& hulls) : pair(hulls), overlay(hulls), descent(overlay) {}

  void from(const OverlayVertex& start) {
    suspect |= !descent.run(start);
    n_steps += descent.n_steps();
    const OverlayVertex& found = descent.best();
    if (has_best && std::fabs(found.depth - best.depth) > kSameDepth * best.depth) suspect = true;
    if (!has_best || found.depth < best.depth) best = found;
    has_best = true;
  }
  void along(const Vec3& normal_A, uint32_t vertex_a, uint32_t vertex_b) {
    overlay.support(normal_A, vertex_a, vertex_b);
    from(overlay.near(normal_A, vertex_a, vertex_b));
  }
  void look_elsewhere(const ConvexPairState& state) {
    const Vec3 way = pair.R_AB * centroid_of(pair.b) + pair.p_AB - centroid_of(pair.a);
    if (norm_squared(way) > 0) {
      along(normalized(way), corner_of(pair.a, state.feature_a),
            corner_of(pair.b, state.feature_b));
    }
  }
};

/// The answer of the last query in this one's pose, or of its normal.
void start_from_last(DepthSearch& search, const ConvexPairState& state) {
  OverlayVertex start;
  if (state.overlapping != 0 && search.overlay.at(state.feature_a, state.feature_b, start)) {
    search.from(start);
  } else if (norm_squared(state.normal_A) > 0) {
    search.along(state.normal_A, corner_of(search.pair.a, state.feature_a),
                 corner_of(search.pair.b, state.feature_b));
  }
}

/// The exact minimum, and the features of it.
void fall_back(DepthSearch& search, PenetrationDepth& out) {
  const PolytopeDepth polytope = expand_polytope(search.pair);
  out.fell_back = true;
  out.exact = polytope.exact;
  search.from(search.overlay.near(polytope.normal_A, polytope.vertex_a, polytope.vertex_b));
}

}  // namespace

PenetrationDepth penetration_depth(const HullPair& pair, ConvexPairState& state) {
  if (!is_feature(pair.a, state.feature_a) || !is_feature(pair.b, state.feature_b)) state = {};
  PenetrationDepth out;
  DepthSearch search(pair);
  start_from_last(search, state);
  if (state.overlapping == 0 || ++state.age >= kLookElsewhere) {
    // of a new pair no minimum is known to be the least
    search.suspect |= state.overlapping == 0;
    search.look_elsewhere(state);
    state.age = 0;
  }
  if (search.suspect || !search.has_best) fall_back(search, out);
  OverlayVertex best = search.best;
  out.normal_A = best.normal[0];
  out.feature_a = best.feature[0];
  out.feature_b = best.feature[1];
  state.keep(out, best.depth > 0);
  out.n_steps = search.n_steps;

  out.real = is_real(pair.a, out.feature_a) && is_real(pair.b, out.feature_b);
  // rounding may hide a farther vertex by some 1e-16 m: the depth is that of the direction itself
  uint32_t vertex_a = corner_of(pair.a, out.feature_a);
  uint32_t vertex_b = corner_of(pair.b, out.feature_b);
  best.depth = std::max(best.depth, search.overlay.support(out.normal_A, vertex_a, vertex_b));
  out.depth = best.depth;
  out.point_a = touching_point(pair, best);
  out.point_b = out.point_a - out.depth * out.normal_A;
  return out;
}

}  // namespace haptic
