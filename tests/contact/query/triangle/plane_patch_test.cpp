// SPDX-License-Identifier: GPL-3.0-or-later
// How far a plane stands in for a surface, and how the surface bends: closed forms, and every
// vertex of the mesh.
#include "contact/query/triangle/plane_patch.h"

#include <cmath>

#include "contact/detect/body/contact_reach.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/triangle/plane_extent.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// The patch at the point of the surface nearest to a place, with its face's normal or another.
PlanePatch patch_at(const MeshShapeData& shape, const Vec3& place, const Vec3* normal = nullptr) {
  const ClosestPoint on = closest_point(shape.view(), place, 1);
  REQUIRE(on.found);
  return plane_patch(shape.mesh.view(), on.triangle, on.point_O,
                     normal != nullptr ? *normal : shape.mesh.face_normals[on.triangle]);
}

}  // namespace

TEST_CASE("plane patch: a face ends at its edges, and is flat", "[contact]") {
  const MeshShapeData box = build_shape(make_box({0.03, 0.06, 0.02}));
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p{random.uniform(-0.0149, 0.0149), random.uniform(-0.0299, 0.0299), 0.01};
    const double edge = std::min(0.015 - std::fabs(p.x), 0.03 - std::fabs(p.y));
    const PlanePatch patch = patch_at(box, p);
    CAPTURE(p, edge);
    // the walk begins a thousandth of the way to the middle of its triangle
    CHECK(patch.extent <= std::min(edge + 3e-5, kMaxExtent));
    CHECK(patch.extent >= 0.9 * std::min(edge, kMaxExtent) - 3e-5);
    CHECK(patch.curvature == 0);
  }
}

TEST_CASE("plane patch: a ball, a cylinder and a bore", "[contact][trap]") {
  const double radius = 0.05;
  const MeshShapeData ball = build_shape(make_icosphere(radius, 5));
  const MeshShapeData rod =
      build_shape(make_turned([&](double, double) { return radius; }, -0.05, 0.05, {128, 64}));
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Vec3 u = random.direction();
    const PlanePatch of_ball = patch_at(ball, 2 * radius * u, &u);
    CHECK(of_ball.curvature <= 1.05 / radius);
    CHECK(of_ball.curvature >= 0.75 / radius);
    CHECK(of_ball.extent > 8e-3);
    // a facet is 2 mm long, and beside its middle it leans: of the eight directions the least
    // counts
    const PlanePatch of_facet = patch_at(ball, 2 * radius * u);
    CHECK(of_facet.curvature <= 1.05 / radius);
    CHECK(of_facet.curvature >= 0.4 / radius);
    // along a cylinder nothing bends: a plane that falls away there lets the tool in
    const double angle = random.uniform(0, 6.28);
    const Vec3 beside{2 * radius * std::cos(angle), 2 * radius * std::sin(angle),
                      random.uniform(-0.02, 0.02)};
    CHECK(patch_at(rod, beside).curvature <= 0.05 / radius);
  }
  const MeshShapeData hole = build_shape(make_hole({}));
  CHECK(patch_at(hole, {1e-3, 2e-3, 0}).curvature == 0);
}

TEST_CASE("plane patch: no vertex of a bumpy ball is above where its bend has it",
          "[contact][trap]") {
  Soup soup = make_icosphere(0.03, 5);
  for (Vec3& v : soup.vertices) {
    v = (1 + 0.01 * std::sin(250 * v.x) * std::sin(220 * v.y)) * v;
  }
  const MeshShapeData ball = build_shape(soup);
  Random random(7);
  int curved = 0;
  for (int i = 0; i < 300; ++i) {
    const ClosestPoint on = closest_point(ball.view(), 0.06 * random.direction(), 1);
    const Vec3 n = ball.mesh.face_normals[on.triangle];
    const PlanePatch patch = plane_patch(ball.mesh.view(), on.triangle, on.point_O, n);
    curved += patch.curvature > 0;
    for (const Vec3& v : ball.mesh.vertices) {
      const Vec3 way = v - on.point_O;
      const double height = dot(n, way), along = norm(way - height * n);
      if (along < 2e-3 || along > std::min(4e-3, patch.extent) || height < -5e-3) continue;
      CAPTURE(i, along, height, patch.curvature, patch.extent);
      // a facet is 1.1 mm long, so its sagitta is 5 µm
      CHECK(height <= -0.5 * patch.curvature * along * along + 4e-5);
    }
  }
  CHECK(curved > 20);
}

TEST_CASE("contact reach: two surfaces roll on each other", "[contact][trap]") {
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 5));
  const MeshShapeData small = build_shape(make_icosphere(0.01, 5));
  const MeshShapeData box = build_shape(make_box({0.01, 0.01, 0.01}));
  // the tool's lowest point, at its place, lies on the top of the ball
  const auto reach = [&](const MeshShapeData& tool, const Vec3& lowest_T, const Quat& q) {
    const Vec3 top{0, 0, 0.05};
    const Pose X_OT{top - rotate(q, lowest_T), q};
    return contact_reach(ball.view(), tool.view(), X_OT, top, top, {0, 0, 1}, 0.02);
  };
  CHECK(reach(small, {0, 0, -0.01}, {}).curvature == Approx(1 / 0.06).epsilon(0.25));
  // a face slides over the ball without any bend, a corner as the ball bends
  CHECK(reach(box, {1e-4, 2e-4, -0.005}, {}).curvature == 0);
  const Quat on_corner = from_rotation_vector({std::acos(-1.0) / 4, 0, 0});
  const Quat tilted = from_rotation_vector({0, 0.6155, 0}) * on_corner;
  Vec3 corner;
  for (const Vec3& c : box.mesh.vertices) {
    if (rotate(tilted, c).z < rotate(tilted, corner).z) corner = c;
  }
  CHECK(reach(box, corner, tilted).curvature == Approx(1 / 0.05).epsilon(0.25));
  CHECK(reach(box, corner, tilted).extent > 5e-3);
}
