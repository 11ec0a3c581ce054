// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/soft_detector.cpp and contact/shape/mesh/tool_body.cpp, and for
// what contact/step.cpp does with them.
#include "contact/shape/mesh/tool_body.h"
#include "proto/wire/renderer.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/over_block.h"

namespace haptic {
namespace {

using test::IsNear;

/// A ball of 2 cm over a block of 10 cm whose top is at z = 0.
SessionConfig ball_over_block(Renderer renderer) {
  SessionConfig config = test::over_block(renderer, primitive::Sphere{0.02, 3});
  config.voxel.size = 1e-3;
  config.voxel.offset_layers = 0;
  return config;
}

struct Bench : test::BakedContact {
  using BakedContact::BakedContact;

  std::unique_ptr<ContactSet> answer(const Vec3& tool_W, Renderer renderer) {
    ServoFrame servo{};
    servo.t_ns = 1'000'000;
    servo.X_WT.p = {0, 0, 1};
    servo.X_WP.p = tool_W;
    servo.renderer = static_cast<uint32_t>(renderer);
    return std::make_unique<ContactSet>(contact_step(model, *state, servo, nullptr));
  }
};

}  // namespace

TEST_CASE("body detectors: a ball in a block is pushed out, by triangles, voxels and pieces") {
  const Renderer renderer =
      GENERATE(Renderer::kDirect6, Renderer::kVoxel, Renderer::kLocalized, Renderer::kSensation);
  Bench bench(ball_over_block(renderer));
  const auto set = bench.answer({0.01, 0.02, 0.0095}, renderer);
  CAPTURE(set->contacts.size(), set->flags);
  REQUIRE(set->n_active > 0);
  CHECK((set->flags & kContactNoDetector) == 0);
  CHECK(set->contacts[0].normal_O.z > 0.99);
  CHECK_THAT(set->X_WT.p, IsNear({0.01, 0.02, 0.0095}, 0));
  CHECK_THAT(set->X_WG.p, IsNear({0.01, 0.02, 0.0095}, 0));
  CHECK(set->tool.mass == 0.05);
  // contacts are near the lowest point of the ball
  Vec3 middle_T;
  double weight = 0;
  for (uint32_t i = 0; i < set->n_active; ++i) {
    const Contact& c = set->contacts[i];
    const double push =
        dot(c.normal_O, c.object_point_O + Vec3{0, 0, -0.05} - set->X_WT.p - c.tool_point_T);
    middle_T += push * c.tool_point_T;
    weight += push;
  }
  CHECK_THAT(middle_T / weight, IsNear({0, 0, -0.01}, 1e-3));
  CHECK(bench.answer({0.01, 0.02, 0.0145}, renderer)->n_active == 0);
}

TEST_CASE("body detectors: what a session lacks is flagged, and nothing is rendered") {
  SessionConfig config = ball_over_block(Renderer::kDirect6);
  {
    Bench bench(config);
    CHECK(bench.baked.volumes.empty());
    CHECK(bench.answer({0, 0, 0.0095}, Renderer::kDirect6)->n_active > 0);
    const auto set = bench.answer({0, 0, 0.0095}, Renderer::kVoxel);
    CHECK((set->flags & kContactNoDetector) != 0);
    CHECK((set->flags & kContactNoFreePose) != 0);
    CHECK(set->contacts.size() == 0);
    CHECK((bench.answer({0, 0, 0.0095}, Renderer::kSensation)->flags & kContactNoDetector) != 0);
  }
  config.voxel.is_wanted = config.pieces.is_wanted = 1;
  CHECK(Bench(config).answer({0, 0, 0.0095}, Renderer::kLocalized)->n_active > 0);
  CHECK(Bench(config).answer({0, 0, 0.0095}, Renderer::kVoxel)->n_active > 0);
  config.tool = {};
  Bench point(config);
  CHECK((point.answer({}, Renderer::kDirect6)->flags & kContactNoDetector) != 0);
}

TEST_CASE("body detectors: a change of renderer begins softly") {
  SessionConfig config = ball_over_block(Renderer::kVoxel);
  Bench bench(config);
  bench.answer({0, 0, 0.02}, Renderer::kVoxel);
  const uint64_t before = bench.answer({0, 0, 0.02}, Renderer::kVoxel)->reseeds;
  CHECK(bench.answer({0, 0, 0.02}, Renderer::kDirect6)->reseeds == before + 1);
  CHECK(bench.answer({0, 0, 0.02}, Renderer::kGodObject3)->reseeds == before + 2);
  // they keep the same
  config = ball_over_block(Renderer::kLocalized);
  Bench pieces(config);
  const uint64_t at_first = pieces.answer({0, 0, 0.02}, Renderer::kLocalized)->reseeds;
  CHECK(pieces.answer({0, 0, 0.02}, Renderer::kSensation)->reseeds == at_first + 1);
  CHECK(pieces.answer({0, 0, 0.0095}, Renderer::kSensation)->n_active > 0);
}

TEST_CASE("tool body: what is not given is that of an evenly filled body") {
  ToolConfig config;
  config.mass = 0.3;
  const auto box =
      build_mesh(make_box({0.02, 0.04, 0.06}).vertices, make_box({0.02, 0.04, 0.06}).triangles);
  const ToolBody filled = tool_body(box.view(), config);
  CHECK(filled.mass == 0.3);
  CHECK_THAT(filled.inertia_T, IsNear({0.3 / 12 * (16e-4 + 36e-4), 0.3 / 12 * (36e-4 + 4e-4),
                                       0.3 / 12 * (4e-4 + 16e-4)},
                                      1e-12));
  CHECK(filled.radius == Approx(0.5 * std::sqrt(4e-4 + 16e-4 + 36e-4)));
  config.inertia = {1e-5, 2e-5, 3e-5};
  CHECK(tool_body(box.view(), config).inertia_T == config.inertia);
  config = {};
  config.density = 1000;
  CHECK(tool_body(box.view(), config).mass == Approx(0.048));
  // the body of an open mesh is its box, that of a flat one a ring
  const Soup sheet = make_grid(0.01, 4);
  const ToolBody flat = tool_body(build_mesh(sheet.vertices, sheet.triangles).view(), ToolConfig{});
  CHECK(flat.mass == ToolConfig{}.mass);
  CHECK(flat.inertia_T.x == Approx(flat.mass * 2e-4));
}

}  // namespace haptic
