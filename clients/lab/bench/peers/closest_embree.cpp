// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/closest.h"

#include <cmath>
#include <limits>

#include "clients/lab/bench/peers/embree_scene.h"

namespace haptic {

#ifndef HAPTICD_EMBREE

std::vector<ClosestPeer> embree_peers(const TriangleMesh&) {
  return {};
}

#else

namespace {

/// Closest point of a triangle, without its feature (Ericson 2005, §5.1.5).
Vec3 closest_on(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  }
  const double scale = 1 / (va + vb + vc);
  return a + (vb * scale) * ab + (vc * scale) * ac;
}

struct Query {
  const TriangleMesh* mesh = nullptr;
  Vec3 p_O;
  double least = std::numeric_limits<double>::infinity();  // squared
  Vec3 point_O;
};

bool visit(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<Query*>(arguments->userPtr);
  const auto& [a, b, c] = query.mesh->triangles[arguments->primID];
  const auto& vertices = query.mesh->vertices;
  const Vec3 q = closest_on(query.p_O, vertices[a], vertices[b], vertices[c]);
  const double d = norm_squared(query.p_O - q);
  if (d >= query.least) return false;
  query.least = d, query.point_O = q;
  arguments->query->radius = static_cast<float>(std::sqrt(d)) * (1 + 1e-6F);
  return true;
}

class Scene {
 public:
  explicit Scene(const TriangleMesh& mesh) : mesh_(mesh), scene_(mesh) {}

  Query ask(const Vec3& p_O, float radius) const {
    Query query{.mesh = &mesh_, .p_O = p_O, .point_O = {}};
    RTCPointQuery ball{static_cast<float>(p_O.x), static_cast<float>(p_O.y),
                       static_cast<float>(p_O.z), 0, radius};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &ball, &context, visit, &query);
    return query;
  }

  Vec3 previous;

 private:
  TriangleMesh mesh_;
  EmbreeScene scene_;
};

}  // namespace

std::vector<ClosestPeer> embree_peers(const TriangleMesh& mesh) {
  const auto scene = std::make_shared<Scene>(mesh);
  scene->previous = mesh.vertices[0];
  const auto cold = [scene](const Vec3& p) {
    return std::sqrt(scene->ask(p, std::numeric_limits<float>::infinity()).least);
  };
  const auto with_previous = [scene](const Vec3& p) {
    const double radius = norm(p - scene->previous) * (1 + 1e-6) + 1e-12;
    const Query found = scene->ask(p, static_cast<float>(radius));
    if (std::isfinite(found.least)) scene->previous = found.point_O;
    return std::sqrt(found.least);
  };
  return {{"Embree, previous radius", with_previous}, {"Embree", cold}};
}

#endif

}  // namespace haptic
