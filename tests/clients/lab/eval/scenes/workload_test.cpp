// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/workload.h"

#include <catch2/catch.hpp>

#include "contact/shape/mesh/mesh_topology.h"

using namespace haptic;

TEST_CASE("eval workload: both families have the published counts and are whole", "[lab]") {
  for (const uint32_t n : {1u, 7u, 50u}) {
    Soup soup = make_height_field(n);
    CHECK(soup.triangles.size() == 2 * n * n);
    CHECK(soup.vertices.size() == (n + 1) * (n + 1));
  }
  for (const uint32_t f : {1u, 2u, 16u}) {
    Soup soup = make_bumpy_sphere(f);
    CHECK(soup.triangles.size() == 20 * f * f);
    CHECK(soup.vertices.size() == 10 * f * f + 2);
    const MeshData mesh = build_mesh(soup.vertices, soup.triangles);
    CHECK(mesh.closed);
    // outwards: the volume is positive
    double volume = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      volume += dot(mesh.vertices[a], cross(mesh.vertices[b], mesh.vertices[c])) / 6;
    }
    CHECK(volume > 0);
  }
}

TEST_CASE("eval workload: the tool starts 5 mm above and is dragged 0.6 to 1.4 mm deep", "[lab]") {
  CHECK(field_slide(0, 0).z ==
        Approx(field_height(0, 0.075 * std::sin(0.9)) + 5e-3).epsilon(1e-12));
  double fastest = 0;
  for (int k = 500; k < kEvalTicks; ++k) {
    const double t = 1e-3 * k;
    const Vec3 p = field_slide(t, 1e-3);
    const double depth = field_height(p.x, p.y) + 1e-3 - p.z;
    REQUIRE(depth >= 0.6e-3 - 1e-12);
    REQUIRE(depth <= 1.4e-3 + 1e-12);
    const Vec3 q = sphere_slide(t, 1e-3);
    const double below = bumpy_radius(normalized(q)) + 1e-3 - norm(q);
    REQUIRE(below == Approx(depth).margin(1e-12));
    const Vec3 flat = flat_slide(t + 1e-6) - flat_slide(t - 1e-6);
    fastest = std::max(fastest, norm(flat) / 2e-6);
  }
  CHECK(fastest == Approx(0.134).margin(2e-3));
}

TEST_CASE("eval workload: unknown names are refused", "[lab]") {
  CHECK(is_eval_work("hf:742"));
  for (const char* name :
       {"hf", "hf:", "hf:0", "hf:-1", "hf:1501", "hf:7x", "cube:3", "bunny.off"}) {
    CHECK_FALSE(is_eval_work(name));
    CHECK_THROWS(make_eval_work(name, 0));
  }
}
