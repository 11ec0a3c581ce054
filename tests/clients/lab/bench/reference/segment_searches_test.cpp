// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/segment_searches.h"

#include <catch2/catch.hpp>

#include "tests/support/meshes.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("segment searches: each finds what contact's own search finds") {
  Soup waves = make_grid(0.05, 12);
  for (Vec3& v : waves.vertices) v.z = 0.01 * std::sin(90 * v.x) * std::cos(70 * v.y);
  for (const Soup& soup : {make_icosphere(0.05, 3), waves, make_degenerate_soup(6, 300)}) {
    const MeshShapeData shape = build_shape(soup);
    MeshShapeData without_grid = shape;
    without_grid.grid = {};
    Random random(14);
    size_t hits = 0;
    for (size_t i = 0; i < sweep(2000); ++i) {
      // short ones at the surface; every tenth from anywhere to anywhere
      const bool is_short = i % 10 != 0;
      const TriangleMesh mesh = shape.mesh.view();
      const Vec3 from =
          is_short ? random.on_surface(mesh) + 0.002 * random.direction() : random.near_mesh(mesh);
      const Vec3 to = is_short ? from + 0.004 * random.direction() : random.near_mesh(mesh);
      const SegmentHit own = first_hit(shape.view(), from, to);
      hits += own.hit;
      CAPTURE(i, from, to, own.t, own.triangle);
      for (const MeshShapeData* data : {&shape, &std::as_const(without_grid)}) {
        for (const auto search : {first_hit_by_grid, first_hit_by_tree, first_hit_naive}) {
          const SegmentHit other = search(data->view(), from, to);
          REQUIRE(other.hit == own.hit);
          if (!own.hit) continue;
          REQUIRE(other.t == own.t);
          REQUIRE(other.triangle == own.triangle);
        }
      }
    }
    CHECK(hits > sweep(2000) / 20);
  }
}
