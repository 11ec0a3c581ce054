// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/place.h"

#include <algorithm>

#include "clients/lab/eval/oracle/walls.h"
#include "contact/query/triangle/closest_on_triangle.h"

namespace haptic {
namespace {

constexpr long double kSameWay = 1e-12L;  // difference of unit normals that count as equal

bool is_on_border(const TriangleMesh& mesh, const Feature& feature, uint32_t triangle) {
  if (mesh.closed || feature.kind == FeatureKind::kFace) return false;
  if (feature.kind == FeatureKind::kEdge) return mesh.edge_faces[feature.index][1] == kNoFace;
  const auto& edges = mesh.triangle_edges[triangle];
  return std::any_of(edges.begin(), edges.end(),
                     [&](uint32_t e) { return mesh.edge_faces[e][1] == kNoFace; });
}

}  // namespace

BehindSurface behind_surface(const FacetBins& facets, const Vec3& centre_O, double radius,
                             double max_distance) {
  const TriangleMesh& mesh = facets.mesh();
  ClosestPoint nearest;
  nearest.distance = radius + max_distance;
  for (const uint32_t t : facets.within(centre_O, nearest.distance)) {
    const ClosestPoint c = closest_point_on_triangle(mesh, t, centre_O);
    if (c.distance < nearest.distance) nearest = c;
  }
  if (!nearest.found) return {};
  // a border has no inside, but a sphere must keep its distance from it
  const bool border = is_on_border(mesh, nearest.feature, nearest.triangle);
  if (border && radius == 0) return {};
  const Vec3 away = centre_O - nearest.point_O;
  const bool behind = !border && dot(away, pseudo_normal(mesh, nearest.feature)) < 0;
  const double height = behind ? -nearest.distance : nearest.distance;
  return {std::max(radius - height, 0.0), true};
}

double free_descent(const FacetBins& facets, const Vec3& proxy_O, const Vec3& tool_O,
                    double radius) {
  std::vector<Wall> walls;
  for (const uint32_t t : facets.within(proxy_O, radius + kTouch)) {
    const Vec3 nearest_O = closest_on_triangle(facets.mesh(), t, proxy_O).point;
    const Long3 away = widened<long double>(proxy_O) - widened<long double>(nearest_O);
    if (norm(away) > static_cast<long double>(radius + kTouch)) continue;
    const Long3 normal = radius > 0 ? normalized(away) : facets[t].normal;
    const bool known = std::any_of(walls.begin(), walls.end(), [&](const Wall& wall) {
      return norm(wall.normal - normal) < kSameWay;
    });
    if (!known && norm(normal) > 0) walls.push_back({normal, 0});
  }
  const auto way = nearest_in(walls, widened<long double>(tool_O) - widened<long double>(proxy_O));
  return way ? static_cast<double>(norm(way->y)) : 0;
}

}  // namespace haptic
