// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "contact/query/point/closest_point.h"
#include "contact/query/proximity/mesh_distance.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/mesh/primitives.h"
#include "contact/shape/parts/dimpled_ball.h"
#include "proto/math/units.h"
#include "tests/contact/shape/parts/solid.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Vec3 sides(const Soup& soup) {
  Vec3 lower = soup.vertices.front(), upper = lower;
  for (const Vec3& v : soup.vertices) {
    lower = component_min(lower, v);
    upper = component_max(upper, v);
  }
  return upper - lower;
}

/// Volume of a sphere of radius r below the height z.
double below(double r, double z) {
  return kPi * (r * r * (z + r) - (z * z * z + r * r * r) / 3);
}

}  // namespace

TEST_CASE("generated meshes: solids without self-intersections, by CGAL", "[contact]") {
  // coarser ones under a sanitizer
  const uint32_t share = kSlowdown > 1 ? 4 : 1;
  check_solid(make_lower_molar({.around = 264 / share}));
  check_solid(make_upper_molar({{.around = 264 / share}}));
  check_solid(make_joint_ball({.around = 240 / share}));
  check_solid(make_joint_socket({.around = 240 / share}));
  check_solid(make_joint_socket({.cover = 0.7 * kPi, .around = 60}));
  check_solid(make_dimpled_ball({.along = 40 / share}));
  // the fewest steps
  check_solid(make_lower_molar({.around = 6}));
  check_solid(make_upper_molar({{.around = 6}}));
  check_solid(make_joint_ball({.around = 6}));
  check_solid(make_joint_socket({.around = 6}));
  check_solid(make_dimpled_ball({.along = 1}));
}

TEST_CASE("generated meshes: how many triangles they have, and the same each time") {
  const Soup lower = make_lower_molar({}), upper = make_upper_molar({});
  CHECK(lower.triangles.size() == 24552);
  CHECK(upper.triangles.size() == 24552);
  const Soup ball = make_joint_ball({}), socket = make_joint_socket({});
  CHECK(ball.triangles.size() + socket.triangles.size() >= 40000);
  CHECK(make_dimpled_ball({}).triangles.size() == 134480);
  CHECK(make_lower_molar({}).vertices == lower.vertices);
  // finer by the resolution
  CHECK(make_lower_molar({.around = 528}).triangles.size() > 3 * lower.triangles.size());
}

TEST_CASE("molars: as wide as stated, in proportion") {
  const Vec3 lower = sides(make_lower_molar({.width = 33e-3}));
  CHECK(lower.y == Approx(33e-3).epsilon(1e-3));
  CHECK(lower.x == Approx(33e-3 * 10.2 / 11).epsilon(0.01));
  const Vec3 upper = sides(make_upper_molar({{.width = 33e-3}, 0.15e-3}));
  CHECK(upper.y == Approx(33e-3 * 10.4 / 11).epsilon(1e-3));
  CHECK(upper.x == Approx(33e-3 * 11.4 / 11).epsilon(0.01));
}

TEST_CASE("molars: shut, they do not meet, and touch over a large surface", "[trap]") {
  if (kSlowdown > 1) return;
  const primitive::UpperMolar molars;
  const MeshShapeData lower = build_shape(make_lower_molar(molars)),
                      upper = build_shape(make_upper_molar(molars));
  CHECK(triangle_pairs(lower.view(), upper.view(), {}, {}) == 0);
  // never nearer than half of the clearance, chords and slopes included
  const double least = mesh_distance(lower.view(), upper.view(), {}).at_least;
  CHECK(least > 0.4 * molars.clearance);
  CHECK(least < molars.clearance);
  // of the lower chewing surface a third is within a clearance of the upper one
  size_t near = 0, top = 0;
  for (size_t i = 0; i < lower.mesh.vertices.size(); i += 7) {
    const Vec3& v = lower.mesh.vertices[i];
    if (lower.mesh.vertex_normals[i].z < 0.5) continue;
    ++top;
    if (closest_point(upper.view(), v, 1).distance <= molars.clearance) ++near;
  }
  CHECK(3 * near > top);
  // and a little deeper they meet
  CHECK(triangle_pairs(lower.view(), upper.view(), {{0, 0, -1.1 * molars.clearance}, {}}, {}) > 0);
}

TEST_CASE("ball joint: volumes are those of ball, stem, cup and cavity") {
  const primitive::JointBall joint;
  const double r = 0.5 * joint.diameter, s = 0.5 * joint.stem;
  const double joined = std::sqrt(r * r - s * s);
  const double ball = below(r, joined) + kPi * s * s * (joint.length - joined);
  const double facets = 1e-3;  // chords of 240 steps
  CHECK(volume(make_joint_ball(joint)) == Approx(ball).epsilon(facets));
  const primitive::JointSocket socket;
  const double c = r + socket.clearance, rim = -c * std::cos(socket.cover);
  const double outer = 0.5 * socket.width;
  const double cup = kPi * outer * outer * (rim + socket.height) - below(c, rim);
  CHECK(volume(make_joint_socket(socket)) == Approx(cup).epsilon(facets));
}

TEST_CASE("ball joint: the ball is free in its socket, however it is turned") {
  if (kSlowdown > 1) return;
  const primitive::JointSocket joint;
  const MeshShapeData ball = build_shape(make_joint_ball({})),
                      socket = build_shape(make_joint_socket(joint));
  const double sagitta = 0.5 * joint.diameter * (1 - std::cos(1.1 * 2 * kPi / joint.around));
  Random random(22);
  for (int i = 0; i < 5; ++i) {
    const Pose X{{}, from_rotation_vector(random.uniform(0, 0.4) * random.direction())};
    const double least = mesh_distance(socket.view(), ball.view(), X).at_least;
    CHECK(least > joint.clearance - sagitta);
    CHECK(least <= joint.clearance + sagitta);
  }
}

TEST_CASE("dimpled ball: volume of the ball less that of its dimples") {
  const primitive::DimpledBall ball;
  const double r = 0.5 * ball.diameter, sphere = 4 * kPi * r * r * r / 3;
  // chords of 1/92 of the radius
  CHECK(volume(make_dimpled_ball({.depth = 0})) == Approx(sphere).epsilon(2e-4));
  // paraboloids: half of base area times depth
  const double base = 2 * kPi * r * r * (1 - std::cos(kDimpleAngle));
  const double dimples = kDimples * 0.5 * base * ball.depth;
  const double less = volume(make_dimpled_ball({.depth = 0})) - volume(make_dimpled_ball(ball));
  CHECK(less == Approx(dimples).epsilon(0.03));
}

TEST_CASE("dimpled ball: dimples do not touch each other") {
  const Soup middles = make_geodesic(6);
  REQUIRE(middles.vertices.size() == kDimples);
  double nearest = kPi;
  for (size_t i = 0; i < middles.vertices.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, std::acos(dot(middles.vertices[i], middles.vertices[j])));
    }
  }
  CHECK(nearest > 2 * kDimpleAngle);
  CHECK(nearest == Approx(0.163).epsilon(0.01));
}
