// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/query/box/obb_overlap.cpp and contact/shape/mesh/feature_owners.cpp.
#include "contact/query/box/obb_overlap.h"

#include <catch2/catch.hpp>
#include <set>

#include "contact/shape/mesh/feature_owners.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Vec3 random_point(Random& random, const CompactObb& compact) {
  const Obb box = compact.unpacked();
  return box.centre_O + transpose(box.R_BO) * random.in_box(-box.half, box.half);
}

}  // namespace

TEST_CASE("obb overlap: no window leaves out a time at which the boxes share a point",
          "[contact]") {
  Random random(11);
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const MeshShapeData sheet = build_shape(make_rough_sheet(8, 6, 1e-3));
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const CompactObb& a = ball.tree.nodes[random.index(ball.tree.nodes.size())].box;
    const CompactObb& b = sheet.tree.nodes[random.index(sheet.tree.nodes.size())].box;
    // a point of each at the same place, at some time of the sweep
    const double angle = trial % 3 == 0 ? 0 : random.uniform(0, trial % 3 == 1 ? 0.1 : 3);
    const RigidMotion free = motion_between({},
                                            {random.uniform(0, 0.1) * random.direction(),
                                             from_rotation_vector(angle * random.direction())},
                                            0.05 * random.direction());
    const double time = random.uniform(0.2, 0.7);
    const Pose there = free.at(time);
    const Vec3 onto = random_point(random, a) - there * random_point(random, b);
    RigidMotion motion = free;
    motion.centre_O += onto;
    const SweepWindow window = when_boxes_may_meet(a, b, sweep_between(motion, 0.2, 0.7));
    const double s = (time - 0.45) / 0.25;
    REQUIRE(window.enter <= s + 1e-9);
    REQUIRE(window.leave >= s - 1e-9);
  }
}

TEST_CASE("obb overlap: a window ends where two boxes that pass each other part", "[contact]") {
  const CompactObb box{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1e-3F, 1e-3F, 1e-3F}, {}};
  // 10 mm along x past each other: they touch from 3 to 7 mm
  const RigidMotion passing = motion_between({{-5e-3, 1e-3, 0}, {}}, {{5e-3, 1e-3, 0}, {}}, {});
  const SweepWindow window = when_boxes_may_meet(box, box, sweep_between(passing, 0, 1));
  CHECK(window.enter == Approx(-0.4).margin(1e-4));
  CHECK(window.leave == Approx(0.4).margin(1e-4));
  const RigidMotion beside = motion_between({{-5e-3, 3e-3, 0}, {}}, {{5e-3, 3e-3, 0}, {}}, {});
  CHECK(when_boxes_may_meet(box, box, sweep_between(beside, 0, 1)).is_empty());
}

TEST_CASE("obb overlap: sphere bound conservative against 10,000 time samples", "[contact][trap]") {
  Random random(12);
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const MeshShapeData sheet = build_shape(make_rough_sheet(8, 6, 1e-3));
  const auto radius = [](const CompactObb& box) { return norm(box.unpacked().half); };
  size_t n_met = 0, n_never = 0;
  for (size_t trial = 0; trial < trials(200); ++trial) {
    const CompactObb& a = ball.tree.nodes[random.index(ball.tree.nodes.size())].box;
    const CompactObb& b = sheet.tree.nodes[random.index(sheet.tree.nodes.size())].box;
    const Vec3 centre_a = a.unpacked().centre_O, centre_b = b.unpacked().centre_O;
    const double reach = radius(a) + radius(b);
    // passes by, within some radii or not, while it turns by up to a radian
    const RigidMotion motion = motion_between(
        {centre_a - centre_b + random.uniform(0, 3) * reach * random.direction(), {}},
        {centre_a - centre_b + random.uniform(0, 3) * reach * random.direction(),
         from_rotation_vector(random.uniform(0, 1) * random.direction())},
        centre_b + 0.02 * random.direction());
    const SweepWindow window = when_spheres_may_meet(a, b, sweep_between(motion, 0, 1));
    n_never += window.is_empty();
    for (int k = 0; k <= 10'000; ++k) {
      const double time = 1e-4 * k, s = 2 * time - 1;
      if (norm(motion.at(time) * centre_b - centre_a) > reach) continue;
      ++n_met;
      REQUIRE(window.enter <= s);
      REQUIRE(window.leave >= s);
    }
  }
  CHECK(n_met > 0);
  CHECK(n_never > 0);
}

TEST_CASE("obb overlap: a window of spheres, in closed form", "[contact]") {
  const CompactObb box{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1e-3F, 1e-3F, 1e-3F}, {}};
  // radii √3 mm; 10 mm along x past each other, offset by 2 mm: within √8 mm of the middle
  const RigidMotion passing = motion_between({{-5e-3, 2e-3, 0}, {}}, {{5e-3, 2e-3, 0}, {}}, {});
  const SweepWindow window = when_spheres_may_meet(box, box, sweep_between(passing, 0, 1));
  CHECK(window.enter == Approx(-std::sqrt(8.0) / 5).margin(1e-4));
  CHECK(window.leave == Approx(std::sqrt(8.0) / 5).margin(1e-4));
  const RigidMotion beside = motion_between({{-5e-3, 4e-3, 0}, {}}, {{5e-3, 4e-3, 0}, {}}, {});
  CHECK(when_spheres_may_meet(box, box, sweep_between(beside, 0, 1)).is_empty());
  // rotation about its own centre is unlimited
  const RigidMotion turning =
      motion_between({{4e-3, 0, 0}, {}}, {{4e-3, 0, 0}, from_rotation_vector({0, 0, 3})}, {});
  CHECK(when_spheres_may_meet(box, box, sweep_between(turning, 0, 1)).is_empty());
}

TEST_CASE("feature owners: every vertex and every edge has one triangle that answers",
          "[contact]") {
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const FeatureOwners owners(ball.mesh.view());
  std::multiset<uint32_t> vertices, edges;
  for (uint32_t t = 0; t < ball.mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const auto corner = static_cast<size_t>(i);
      if (owners.has_vertex(t, i)) vertices.insert(ball.mesh.triangles[t][corner]);
      if (owners.has_edge(t, i)) edges.insert(ball.mesh.triangle_edges[t][corner]);
    }
  }
  CHECK(vertices.size() == ball.mesh.vertices.size());
  CHECK(std::set<uint32_t>(vertices.begin(), vertices.end()).size() == vertices.size());
  CHECK(edges.size() == ball.mesh.edge_faces.size());
  CHECK(std::set<uint32_t>(edges.begin(), edges.end()).size() == edges.size());
}
