// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/admittance/free_region.cpp: the region that a set proves free for a point, in a
// corner of two planes that is written out.
#include "servo/admittance/free_region.h"

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 2e-3;

/// A floor at z = 0 of object 0 and a wall at x = 0 of object 1, each known for half a millimetre.
ContactSet corner() {
  ContactSet set{};
  set.contacts.resize(2);
  set.objects.resize(2);
  set.contacts[0].normal_O = {0, 0, 1};
  set.contacts[1].normal_O = {1, 0, 0};
  set.contacts[1].object = 1;
  for (Contact& c : set.contacts) c.extent = 0.5e-3;
  return set;
}

TickScene at_rest() {
  TickScene scene;
  scene.X_WO.resize(2);
  scene.V_WO.resize(2);
  return scene;
}

}  // namespace

TEST_CASE("free region: in front of each plane, however far along it", "[servo]") {
  const FreeRegion region = free_region(corner(), at_rest(), 0);
  REQUIRE(region.size == 2);
  CHECK(holds(region, {1e-3, 0, 1e-3}));
  CHECK(holds(region, {0, 5, 0}));
  // a solver would let a point past both, so far from where they are known
  CHECK_FALSE(holds(region, {1, 1, -1e-9}));
  CHECK_FALSE(holds(region, {-1e-9, 1, 1}));
}

TEST_CASE("free region: a sphere keeps its radius", "[servo]") {
  const FreeRegion region = free_region(corner(), at_rest(), kRadius);
  CHECK(holds(region, {kRadius, 0, kRadius}));
  CHECK_FALSE(holds(region, {kRadius, 0, kRadius - 1e-9}));
}

TEST_CASE("free region: planes go along with their object, and bound nothing while it moves",
          "[servo]") {
  TickScene scene = at_rest();
  scene.X_WO[1].p = {0.1, 0, 0};
  CHECK_FALSE(holds(free_region(corner(), scene, 0), {0.09, 0, 0}));
  CHECK(holds(free_region(corner(), scene, 0), {0.11, 0, 0}));
  scene.V_WO[1].v = {0.2, 0, 0};
  const FreeRegion region = free_region(corner(), scene, 0);
  CHECK(holds(region, {0.09, 0, 0}));
  CHECK_FALSE(holds(region, {0.09, 0, -1e-9}));
}

TEST_CASE("free region: contacts that are not finite prove nothing", "[servo]") {
  ContactSet set = corner();
  set.contacts[1].object_point_O.x = std::nan("");
  CHECK(free_region(set, at_rest(), 0).size == 0);
}

TEST_CASE("free region: the nearest place, and never a longer way than asked for", "[servo]") {
  const FreeRegion region = free_region(corner(), at_rest(), 0);
  CHECK_THAT(brought_into(region, {0.3, 0.2, -0.1}), IsNear({0.3, 0.2, 0}, 1e-15));
  CHECK_THAT(brought_into(region, {-0.3, 0.2, -0.1}), IsNear({0, 0.2, 0}, 1e-15));
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 from = brought_into(region, random.uniform(0, 1) * random.direction());
    const Vec3 to = random.uniform(0, 1) * random.direction();
    const Vec3 kept = brought_into(region, to);
    REQUIRE(holds(region, kept));
    CHECK(norm(kept - from) <= norm(to - from) + 1e-12);
  }
}
