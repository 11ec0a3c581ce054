// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/parts/machine_parts.h"

#include <numbers>

#include "contact/query/point/closest_point.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "proto/math/units.h"
#include "tests/contact/shape/parts/solid.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr primitive::Thread kBoltThread{.grid = {96, 140}}, kNutThread{.grid = {96, 56}};

double volume(const MeshShapeData& part) {
  return test::volume(part.mesh.vertices, part.mesh.triangles);
}

double least_gap(const MeshShapeData& part, const MeshShapeData& other) {
  double least = 1;
  for (const Vec3& v : part.mesh.vertices) {
    const ClosestPoint c = closest_point(other.view(), v, 1);
    least = std::min(least, c.inside ? -c.distance : c.distance);
  }
  return least;
}

}  // namespace

TEST_CASE("machine parts: closed, facing outwards, of the right volume", "[contact]") {
  const MeshShapeData peg = build_shape(make_peg({})), hole = build_shape(make_hole({}));
  for (const MeshShapeData* part : {&peg, &hole}) CHECK(part->mesh.closed);
  CHECK(volume(peg) == Approx(kPi * 1e-4 * 0.04).epsilon(2e-3));
  CHECK(volume(hole) == Approx((3.6e-3 - kPi * 10.2e-3 * 10.2e-3) * 0.04).epsilon(5e-3));
  for (const Soup& part :
       {make_gear({.grid = {480, 4}}), make_bolt({kBoltThread}), make_nut({kNutThread})}) {
    const MeshShapeData shape = build_shape(part);
    CHECK(shape.mesh.closed);
    CHECK(volume(shape) > 0);
  }
}

TEST_CASE("machine parts: the peg fits the hole, the bolt the nut, all along", "[contact]") {
  const MeshShapeData peg = build_shape(make_peg({})), hole = build_shape(make_hole({}));
  CHECK(least_gap(peg, hole) > 0.15e-3);
  CHECK(least_gap(peg, hole) <= 0.2e-3 + 1e-9);
  if (kSlowdown > 1) return;
  const MeshShapeData bolt = build_shape(make_bolt({kBoltThread})),
                      nut = build_shape(make_nut({kNutThread}));
  CHECK(least_gap(bolt, nut) > 0.005e-3);
  CHECK(least_gap(bolt, nut) < 0.05e-3);
}

TEST_CASE("machine parts: the bolt is free in the nut, triangle by triangle", "[contact][trap]") {
  if (kSlowdown > 1) return;
  // 27,072 and 38,784 triangles, rings of both at the same heights
  const primitive::Bolt screw{kBoltThread};
  primitive::Nut around{kBoltThread};
  around.grid.along = 100;
  around.height = screw.length * 100 / 140;
  const MeshShapeData bolt = build_shape(make_bolt(screw)), nut = build_shape(make_nut(around));
  REQUIRE(bolt.mesh.triangles.size() == 27072);
  REQUIRE(nut.mesh.triangles.size() == 38784);
  CHECK(triangle_pairs(nut.view(), bolt.view(), {}, {}) == 0);
  // from 20 µm at the flanks to 50 µm at the crests
  const double gap = least_gap(bolt, nut);
  CHECK(gap > 0.01e-3);
  CHECK(gap < 0.06e-3);
}

TEST_CASE("machine parts: two gears mesh", "[contact]") {
  if (kSlowdown > 1) return;
  const primitive::Gear gear{12, 3e-3, 10e-3, 8e-3, 0.2e-3, {720, 2}};
  const MeshShapeData one = build_shape(make_gear(gear));
  // the other gear is a pitch diameter away and rotated by half a tooth: its tooth is in a gap
  Soup soup = make_gear(gear);
  const Quat turn = from_rotation_vector({0, 0, std::numbers::pi * (1 + 1.0 / gear.teeth)});
  for (Vec3& v : soup.vertices) v = rotate(turn, v) + Vec3{gear.teeth * gear.module, 0, 0};
  const double gap = least_gap(build_shape(soup), one);
  CHECK(gap > 0);
  CHECK(gap < 0.25e-3);
}
