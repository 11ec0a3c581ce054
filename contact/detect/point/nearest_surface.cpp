// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/nearest_surface.h"

#include <algorithm>
#include <limits>

#include "contact/query/point/closest_point.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRimCosine = 0.5;  // least cosine to an open surface's normal; else past its rim

}  // namespace

size_t nearest_surfaces(const PointScene& scene, const Vec3& p_W, double reach,
                        std::span<NearestSurface> out) {
  HAPTIC_ASSERT(scene.shapes.size() <= kMaxObjects && reach >= 0);
  size_t count = 0;
  for (uint32_t i = 0; i < scene.shapes.size() && count < out.size(); ++i) {
    const TriangleMesh& mesh = scene.shapes[i].mesh;
    const Vec3 p_O = inverse(scene.X_WO[i]) * p_W;
    const ClosestPoint c =
        closest_point(scene.shapes[i], p_O, std::numeric_limits<double>::infinity());
    if (!c.found) continue;
    const Vec3 outward_O = pseudo_normal(mesh, c.feature);
    const Vec3 away_O = p_O - c.point_O;
    const double height = dot(away_O, outward_O);
    const bool behind = height < 0;
    if (!behind && c.distance > reach) continue;
    if (!mesh.closed && std::fabs(height) < kRimCosine * c.distance) continue;
    const bool exact = c.feature.kind == FeatureKind::kFace || c.distance < kOnSurface;
    const Vec3 normal_O = exact ? outward_O : (behind ? -1.0 : 1.0) / c.distance * away_O;
    out[count++] = {
        {i, c.triangle}, {c.feature, c.point_O, normal_O}, behind ? c.distance : -c.distance};
  }
  std::sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count),
            [](const NearestSurface& a, const NearestSurface& b) { return a.depth > b.depth; });
  return count;
}

}  // namespace haptic
