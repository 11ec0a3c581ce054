// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/step.cpp with hand-made servo frames.
#include "contact/step.h"

#include <limits>
#include <memory>
#include <utility>

#include "contact/detect/point_detector.h"
#include "proto/wire/renderer.h"
#include "tests/support/frames.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A block of 10 cm around the origin, and its detector.
struct Bench {
  MeshShapeData block = build_shape(make_box({0.1, 0.1, 0.1}));
  ContactModel model;
  std::unique_ptr<ContactState> state = std::make_unique<ContactState>();
  uint64_t tick = 0;

  Bench() {
    SessionConfig config{};
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

PointProxy& proxy_of(ContactState& state) {
  return std::get<PointDetector>(state.detector).proxy;
}

}  // namespace

TEST_CASE("contact step: a hand that feels nothing passes through, and begins where it then is",
          "[contact]") {
  const uint32_t closed = GENERATE(kServoPaused | 0u, kServoDisarmed | 0u, kServoFault | 0u,
                                   kServoTooFast | 0u, kServoNoDevice | 0u);
  Bench b;
  const Vec3 above_W{0, 0, 0.06}, inside_W{0, 0, 0.02}, below_W{0, 0, -0.06};
  b.answer(above_W, 0);
  // rendered: held back at the surface
  CHECK(b.answer(inside_W, kServoContact)->X_WG.p.z > 0.05);
  const uint64_t reseeds = b.answer(inside_W, kServoContact)->reseeds;
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

TEST_CASE("contact step: of a full scene it reads the objects that the session has", "[contact]") {
  Bench b;
  ServoFrame servo{};
  servo.X_WT.p = servo.X_WG.p = {0, 0, 0.06};
  const auto scene = std::make_unique<SceneFrame>();
  scene->objects.resize(kMaxObjects);
  const auto set =
      std::make_unique<ContactSet>(contact_step(b.model, *b.state, servo, scene.get()));
  CHECK(set->X_WG.p == servo.X_WT.p);
  CHECK(set->objects.size() == 1);
}

TEST_CASE("contact step: it counts the frames that it did not answer, and since when") {
  Bench b;
  const auto answered = [&](uint64_t tick, uint64_t skipped) {
    ServoFrame servo{};
    servo.tick = tick;
    servo.t_ns = static_cast<int64_t>(tick) * 1'000'000;
    servo.skipped = skipped;
    const auto set = std::make_unique<ContactSet>(contact_step(b.model, *b.state, servo, nullptr));
    return std::pair{set->skipped, set->behind_since_ns};
  };
  using Lag = std::pair<uint64_t, int64_t>;
  CHECK(answered(100, 3) == Lag{0, 0});
  CHECK(answered(101, 3) == Lag{0, 0});
  CHECK(answered(104, 3) == Lag{2, 104'000'000});
  // the servo has skipped these three itself, and one more frame was missed
  CHECK(answered(109, 6) == Lag{3, 104'000'000});
  CHECK(answered(1108, 1004) == Lag{3, 104'000'000});
  // nothing for a second, then again
  CHECK(answered(1111, 1006) == Lag{3, 0});
  CHECK(answered(1113, 1006) == Lag{4, 1'113'000'000});
  // a servo that has begun anew
  CHECK(answered(5, 0) == Lag{4, 1'113'000'000});
}

TEST_CASE("contact step: a grasp of an object that a scene has no more ends in no force") {
  Bench b;
  b.answer({0, 0, 0.06}, 0);
  b.state->grasp.object = 0;
  b.state->grasp.was_pressed = true;
  b.model.grasp_button = 0;
  ServoFrame servo{};
  servo.tick = 2;
  servo.t_ns = 2'000'000;
  servo.X_WT.p = servo.X_WG.p = {0, 0, 0.06};
  servo.device.buttons = 1;
  const auto none = std::make_unique<SceneFrame>();
  const auto set = std::make_unique<ContactSet>(contact_step(b.model, *b.state, servo, none.get()));
  CHECK(is_finite(set->X_WG));
  CHECK(set->objects.size() == 1);
}

TEST_CASE("contact step: a clutch moves nothing, so the proxy stays", "[contact]") {
  Bench b;
  b.answer({0, 0, 0.06}, 0);
  const auto before = b.answer({0, 0, 0.04}, kServoContact);
  const auto held = b.answer({0, 0, 0.04}, kServoClutched);
  CHECK(held->X_WG.p == before->X_WG.p);
  CHECK(held->reseeds == before->reseeds);
}

TEST_CASE("contact step: witnesses never change a result", "[contact][trap]") {
  const double radius = GENERATE(0.0, 0.3e-3, 2e-3);
  const MeshShapeData sheet = build_shape(make_rough_sheet(3, 40, 0.5));
  SessionConfig config{};
  config.n_objects = 2;
  config.proxy_radius = radius;
  config.objects[1].X_WO.p = {0.03, 0.01, 0.4e-3};
  const std::array shapes{sheet.view(), sheet.view()};
  const MeshShapeData other_data = build_shape(make_icosphere(0.05, 2));
  const MeshShape other = other_data.view();
  const ContactModel model = build_contact_model(config, shapes);
  Random random(5);
  // in the order in which they come, each time new, and of any object
  const auto kept = std::make_unique<ContactState>(model);
  const auto fresh = std::make_unique<ContactState>(model);
  const auto foreign = std::make_unique<ContactState>(model);
  size_t pressed = 0;
  for (uint64_t k = 0; k < trials(300); ++k) {
    const double t = static_cast<double>(k) * 0.02;
    ServoFrame servo{};
    servo.tick = k;
    servo.t_ns = static_cast<int64_t>(k + 1) * 1'000'000;
    servo.renderer = static_cast<uint32_t>(Renderer::kVirtualProxy3);
    servo.X_WT.p = {0.03 * std::sin(t), 0.03 * std::cos(1.7 * t),
                    radius - 0.8e-3 + 2e-3 * std::cos(3 * t)};
    proxy_of(*fresh).witnesses = {};
    for (ProxyWitness& witness : proxy_of(*foreign).witnesses) {
      for (auto& hit : witness.hit) hit.triangle = static_cast<uint32_t>(random.index(4000));
      const MeshShape& any = k % 2 == 0 ? shapes[0] : other;
      closest_point(any, random.near_mesh(any.mesh), 1, witness.beside);
    }
    const auto usual = std::make_unique<ContactSet>(contact_step(model, *kept, servo, nullptr));
    const auto without = std::make_unique<ContactSet>(contact_step(model, *fresh, servo, nullptr));
    const auto misled = std::make_unique<ContactSet>(contact_step(model, *foreign, servo, nullptr));
    CAPTURE(k, radius);
    pressed += usual->n_active > 0;
    REQUIRE((bytes_in_use(*usual) == bytes_in_use(*without)));
    REQUIRE((bytes_in_use(*usual) == bytes_in_use(*misled)));
  }
  CHECK(pressed >= trials(300) / 5);
}
