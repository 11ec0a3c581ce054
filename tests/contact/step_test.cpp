// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/step.cpp with hand-made servo frames.
#include "contact/step.h"

#include <cstring>
#include <limits>
#include <memory>

#include "contact/detect/point_detector.h"
#include "proto/wire/renderer.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using haptic::ContactSet;
using haptic::ServoFrame;
using haptic::Vec3;

namespace {

/// A block of 10 cm around the origin, and its detector.
struct Bench {
  haptic::MeshShapeData block = haptic::build_shape(haptic::make_box({0.1, 0.1, 0.1}));
  haptic::ContactModel model;
  std::unique_ptr<haptic::ContactState> state = std::make_unique<haptic::ContactState>();
  uint64_t tick = 0;

  Bench() {
    haptic::SessionConfig config{};
    config.n_objects = 1;
    const std::array shapes{block.view()};
    model = build_contact_model(config, shapes);
  }

  std::unique_ptr<ContactSet> answer(const Vec3& tool_W, uint32_t flags) {
    ServoFrame servo{};
    servo.tick = ++tick;
    servo.t_ns = static_cast<int64_t>(tick) * 1'000'000;
    servo.X_WT.p = servo.X_WG.p = tool_W;
    servo.flags = flags;
    return std::make_unique<ContactSet>(contact_step(model, *state, servo, nullptr));
  }
};

haptic::PointProxy& proxy_of(haptic::ContactState& state) {
  return state.detector.keep<haptic::LedPoint>().proxy;
}

}  // namespace

TEST_CASE("contact step: a hand that feels nothing passes through, and begins where it then is",
          "[contact]") {
  const uint32_t closed =
      GENERATE(haptic::kServoPaused | 0u, haptic::kServoDisarmed | 0u, haptic::kServoFault | 0u,
               haptic::kServoTooFast | 0u, haptic::kServoNoDevice | 0u);
  Bench b;
  const Vec3 above_W{0, 0, 0.06}, inside_W{0, 0, 0.02}, below_W{0, 0, -0.06};
  b.answer(above_W, 0);
  // rendered: held back at the surface
  CHECK(b.answer(inside_W, haptic::kServoContact)->X_WG.p.z > 0.05);
  const uint64_t reseeds = b.answer(inside_W, haptic::kServoContact)->reseeds;
  // not rendered: no longer held back, and the servo is told to start softly
  const auto passing = b.answer({0, 0, -0.04}, closed);
  CHECK(passing->X_WG.p.z < -0.05);
  CHECK(passing->reseeds > reseeds);
  const auto through = b.answer(below_W, closed);
  CHECK(through->X_WG.p == below_W);
  const auto felt = b.answer(below_W, 0);
  CHECK(felt->X_WG.p == below_W);
  CHECK(felt->n_active == 0);
}

TEST_CASE("contact step: a restarted contact does not begin at a pose that is not finite",
          "[contact]") {
  Bench b;
  ServoFrame servo{};
  servo.X_WT.p = {0, 0, 0.06};
  servo.X_WG.p = {0, 0, std::numeric_limits<double>::quiet_NaN()};
  const auto set = std::make_unique<ContactSet>(contact_step(b.model, *b.state, servo, nullptr));
  CHECK(set->X_WG.p == servo.X_WT.p);
}

TEST_CASE("contact step: a scene that claims more objects than it can hold is read to its end",
          "[contact]") {
  Bench b;
  ServoFrame servo{};
  servo.X_WT.p = servo.X_WG.p = {0, 0, 0.06};
  const auto scene = std::make_unique<haptic::SceneFrame>();
  scene->n_objects = 1u << 20;
  const auto set =
      std::make_unique<ContactSet>(contact_step(b.model, *b.state, servo, scene.get()));
  CHECK(set->X_WG.p == servo.X_WT.p);
}

TEST_CASE("contact step: a clutch moves nothing, so the proxy stays", "[contact]") {
  Bench b;
  b.answer({0, 0, 0.06}, 0);
  const auto before = b.answer({0, 0, 0.04}, haptic::kServoContact);
  const auto held = b.answer({0, 0, 0.04}, haptic::kServoClutched);
  CHECK(held->X_WG.p == before->X_WG.p);
  CHECK(held->reseeds == before->reseeds);
}

TEST_CASE("contact step: witnesses never change a result", "[contact][trap]") {
  const double radius = GENERATE(0.0, 0.3e-3, 2e-3);
  const haptic::MeshShapeData sheet =
      haptic::build_shape(haptic::test::make_rough_sheet(3, 40, 0.5));
  haptic::SessionConfig config{};
  config.n_objects = 2;
  config.proxy_radius = radius;
  config.objects[1].X_WO.p = {0.03, 0.01, 0.4e-3};
  const std::array shapes{sheet.view(), sheet.view()};
  const haptic::MeshShapeData other_data = haptic::build_shape(haptic::make_icosphere(0.05, 2));
  const haptic::MeshShape other = other_data.view();
  const haptic::ContactModel model = build_contact_model(config, shapes);
  haptic::test::Random random(5);
  // in the order in which they come, each time new, and of any object
  const auto kept = std::make_unique<haptic::ContactState>(model);
  const auto fresh = std::make_unique<haptic::ContactState>(model);
  const auto foreign = std::make_unique<haptic::ContactState>(model);
  size_t pressed = 0;
  for (uint64_t k = 0; k < haptic::test::trials(300); ++k) {
    const double t = static_cast<double>(k) * 0.02;
    ServoFrame servo{};
    servo.tick = k;
    servo.t_ns = static_cast<int64_t>(k + 1) * 1'000'000;
    servo.renderer = static_cast<uint32_t>(haptic::Renderer::kVirtualProxy3);
    servo.X_WT.p = {0.03 * std::sin(t), 0.03 * std::cos(1.7 * t),
                    radius - 0.8e-3 + 2e-3 * std::cos(3 * t)};
    proxy_of(*fresh).witnesses = {};
    for (haptic::ProxyWitness& witness : proxy_of(*foreign).witnesses) {
      for (auto& hit : witness.hit) hit.triangle = static_cast<uint32_t>(random.index(4000));
      const haptic::MeshShape& any = k % 2 == 0 ? shapes[0] : other;
      closest_point(any, random.near_mesh(any.mesh), 1, witness.beside);
    }
    const auto usual = std::make_unique<ContactSet>(contact_step(model, *kept, servo, nullptr));
    const auto without = std::make_unique<ContactSet>(contact_step(model, *fresh, servo, nullptr));
    const auto misled = std::make_unique<ContactSet>(contact_step(model, *foreign, servo, nullptr));
    CAPTURE(k, radius);
    pressed += usual->n_active > 0;
    REQUIRE(std::memcmp(usual.get(), without.get(), sizeof(ContactSet)) == 0);
    REQUIRE(std::memcmp(usual.get(), misled.get(), sizeof(ContactSet)) == 0);
  }
  CHECK(pressed >= haptic::test::trials(300) / 5);
}
