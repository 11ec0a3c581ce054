// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/distance_field.h"

#include "contact/query/point/closest_point.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.05;

double sphere(const Vec3& p) {
  return norm(p) - kRadius;
}

DistanceFieldData sphere_field(double cell, double band) {
  const Vec3 corner = kRadius * Vec3{1, 1, 1};
  return build_distance_field(-corner, corner, sphere, {cell, band, band});
}

}  // namespace

TEST_CASE("distance field: sphere within half a cell squared times curvature", "[contact]") {
  // |φ − exact| ≤ 0.5·cell²·curvature, gradient norm 1 ± 2 %
  const double cell = 1e-3, band = 5e-3;
  const DistanceFieldData data = sphere_field(cell, band);
  Random random(1);
  for (size_t i = 0; i < trials(50000); ++i) {
    const Vec3 p = (kRadius + random.uniform(-0.6, 0.6) * band) * random.direction();
    const FieldSample s = sample_field(data.view(), p);
    REQUIRE(s.is_near);
    const double rounding = band / 32767;
    REQUIRE(std::fabs(s.distance - sphere(p)) <= 0.5 * cell * cell / (kRadius - band) + rounding);
    REQUIRE(norm(s.gradient_O) == Approx(1).epsilon(0.02));
    REQUIRE(dot(s.gradient_O, normalized(p)) > 0.98);
  }
}

TEST_CASE("distance field: continuous across every border", "[contact][trap]") {
  const DistanceFieldData data = sphere_field(2e-3, 6e-3);
  Random random(2);
  for (size_t i = 0; i < trials(50000); ++i) {
    // from one side of a plane of nodes to the other, including borders of bricks
    const double plane = data.lower_O.x + data.cell * static_cast<double>(random.index(50));
    const Vec3 p = (kRadius + random.uniform(-1e-3, 1e-3)) * random.direction();
    const Vec3 at{plane, p.y, p.z};
    if (std::fabs(sphere(at)) > 5e-3) continue;
    const FieldSample left = sample_field(data.view(), at - Vec3{1e-9, 0, 0});
    const FieldSample right = sample_field(data.view(), at + Vec3{1e-9, 0, 0});
    REQUIRE(std::fabs(left.distance - right.distance) <= 5e-9);
  }
}

TEST_CASE("distance field: what is far is a bound of the right sign", "[contact]") {
  const DistanceFieldData data = sphere_field(1e-3, 2e-3);
  Random random(3);
  size_t far = 0;
  for (size_t i = 0; i < trials(50000); ++i) {
    const Vec3 p = 0.1 * random.in_box({-1, -1, -1}, {1, 1, 1});
    const FieldSample s = sample_field(data.view(), p);
    if (s.is_near) continue;
    ++far;
    REQUIRE(std::fabs(s.distance) <= std::fabs(sphere(p)) + 1e-6);
    REQUIRE((s.distance == 0 || (s.distance < 0) == (sphere(p) < 0)));
    REQUIRE(std::fabs(sphere(p)) > 2e-3);
  }
  CHECK(far > trials(50000) / 2);
}

TEST_CASE("distance field: of a mesh it is its closest point", "[contact]") {
  const MeshShapeData shape = build_shape(make_box({0.06, 0.04, 0.02}));
  const TriangleMesh mesh = shape.mesh.view();
  const auto distance = [&](const Vec3& p) {
    const ClosestPoint c = closest_point(shape.view(), p, 1);
    return c.inside ? -c.distance : c.distance;
  };
  double done = 0;
  const DistanceFieldData data = build_distance_field(
      mesh.lower, mesh.upper, distance, {1e-3, 3e-3, 3e-3},
      [](const auto& first, const auto& second) { second(), first(); },
      [&](double share) {
        REQUIRE(share > done);
        done = share;
      });
  CHECK(done == 1);
  Random random(4);
  for (size_t i = 0; i < trials(20000); ++i) {
    const Vec3 p = random.on_surface(mesh) + 2e-3 * random.direction();
    const FieldSample s = sample_field(data.view(), p);
    REQUIRE(s.is_near);
    REQUIRE(std::fabs(s.distance - distance(p)) <= 0.9e-3);
  }
}
