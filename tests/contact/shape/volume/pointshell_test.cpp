// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/pointshell.h"

#include <set>

#include "contact/query/point/closest_point.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Vec3 point_of(const Pointshell& shell, uint32_t i) {
  return {static_cast<double>(shell.x[i]), static_cast<double>(shell.y[i]),
          static_cast<double>(shell.z[i])};
}
Vec3 normal_of(const Pointshell& shell, uint32_t i) {
  return {static_cast<double>(shell.nx[i]), static_cast<double>(shell.ny[i]),
          static_cast<double>(shell.nz[i])};
}

}  // namespace

TEST_CASE("pointshell: on the true surface, normals inwards", "[contact][trap]") {
  const Soup soup = GENERATE(make_box({0.06, 0.04, 0.02}), make_icosphere(0.05, 3));
  const MeshShapeData shape = build_shape(soup);
  const PointshellData data = build_pointshell(shape.mesh.view(), 3e-3);
  const Pointshell shell = data.view();
  REQUIRE(shell.x.size() > 100);
  for (uint32_t i = 0; i < shell.x.size(); ++i) {
    const Vec3 p = point_of(shell, i);
    const ClosestPoint c = closest_point(shape.view(), p, 1);
    REQUIRE(c.distance <= tol(1e-8));
    REQUIRE(norm(normal_of(shell, i)) == Approx(1).epsilon(1e-6));
    // a little further along the normal is inside
    const ClosestPoint in = closest_point(shape.view(), p + 1e-5 * normal_of(shell, i), 1);
    if (c.feature.kind == FeatureKind::kFace) REQUIRE(in.inside);
    REQUIRE(norm(p) <= shell.radius);
  }
}

TEST_CASE("pointshell: a symmetric body has symmetric points", "[contact][trap]") {
  // sides that are integer multiples of a cube, and sides that are not
  const Vec3 extent = GENERATE(Vec3{0.02, 0.02, 0.02}, Vec3{0.02, 0.0213, 0.0172});
  const MeshShapeData shape = build_shape(make_box({extent}));
  const PointshellData data = build_pointshell(shape.mesh.view(), 4e-4);
  const Pointshell shell = data.view();
  Vec3 points, normals, size;
  for (uint32_t i = 0; i < shell.x.size(); ++i) {
    const Vec3 p = point_of(shell, i);
    points += p, normals += normal_of(shell, i);
    size += {std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)};
  }
  for (const int k : {0, 1, 2}) {
    CHECK(std::fabs(points[k]) <= 1e-3 * size[k]);
    CHECK(std::fabs(normals[k]) <= 1e-9 * static_cast<double>(shell.x.size()));
  }
}

TEST_CASE("pointshell: every place of the surface has a point nearby, none is twice", "[contact]") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 3));
  const double spacing = 3e-3;
  const PointshellData data = build_pointshell(shape.mesh.view(), spacing);
  const Pointshell shell = data.view();
  Random random(1);
  for (size_t i = 0; i < trials(2000); ++i) {
    const Vec3 q = random.on_surface(shape.mesh.view());
    double nearest = 1;
    for (uint32_t k = 0; k < shell.x.size(); ++k)
      nearest = std::min(nearest, norm(point_of(shell, k) - q));
    REQUIRE(nearest <= std::sqrt(3.0) * spacing);
  }
  // the centre of the mesh is the corner or the centre of a cube, along each axis
  const Vec3 middle = 0.5 * (shape.mesh.lower + shape.mesh.upper);
  size_t most = 0;
  for (int choice = 0; choice < 8; ++choice) {
    const Vec3 off{0.5 * (choice & 1), 0.25 * (choice & 2), 0.125 * (choice & 4)};
    std::set<std::array<double, 3>> cubes;
    for (uint32_t n = 0; n < shell.x.size(); ++n) {
      const Vec3 c = (point_of(shell, n) - middle) / spacing + off;
      cubes.insert({std::floor(c.x), std::floor(c.y), std::floor(c.z)});
    }
    most = std::max(most, cubes.size());
  }
  // rounding to float may move a point on the border of a cube into the next
  CHECK(most >= shell.x.size() - 2);
}

TEST_CASE("pointshell: levels are nested, and their balls hold what is below", "[contact]") {
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 3));
  const PointshellData data = build_pointshell(shape.mesh.view(), 2e-3);
  const Pointshell shell = data.view();
  REQUIRE(shell.levels.size() > 4);
  CHECK(shell.levels.back() == shell.nodes.size());
  CHECK(shell.levels[1] == 1);
  for (size_t level = 0; level + 1 < shell.levels.size(); ++level) {
    uint32_t covered = 0;
    std::set<uint32_t> here;
    for (uint32_t n = shell.levels[level]; n < shell.levels[level + 1]; ++n) {
      const ShellNode& node = shell.nodes[n];
      REQUIRE(node.first == covered);
      covered += node.count;
      here.insert(node.point);
      for (uint32_t i = node.first; i < node.first + node.count; ++i) {
        REQUIRE(norm(point_of(shell, i) - point_of(shell, node.point)) <=
                static_cast<double>(node.radius));
      }
      bool among_children = node.n_children == 0;
      uint32_t below = 0;
      for (uint32_t k = 0; k < node.n_children; ++k) {
        const ShellNode& child = shell.nodes[node.first_child + k];
        among_children |= child.point == node.point;
        below += child.count;
      }
      REQUIRE(among_children);
      if (node.n_children > 0) REQUIRE(below == node.count);
    }
    CHECK(covered == shell.x.size());
    CHECK(here.size() == shell.levels[level + 1] - shell.levels[level]);
  }
}

TEST_CASE("pointshell: nothing of nothing", "[contact]") {
  CHECK(build_pointshell({}, 1e-3).x.empty());
  CHECK(build_pointshell(build_shape(make_box({1, 1, 1})).mesh.view(), 1e-9).x.empty());
}
