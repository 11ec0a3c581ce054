// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer penalty3 in lockstep: its force, and its two artefacts, compared with the
// god-object, which has neither.
#include "clients/lab/eval/artefacts.h"
#include "clients/lockstep/lockstep.h"
#include "proto/ipc/control.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/eval/scripted_run.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

SessionConfig session(Renderer renderer, double stiffness) {
  SessionConfig config = plain_session(stiffness);
  config.renderer = renderer;
  return config;
}

}  // namespace

TEST_CASE("penalty: the force is k times depth along the normal of the nearest face", "[lab]") {
  const auto pressing = [](double t) { return Vec3{0.01, 0.02, 0.052 - 0.05 * t}; };
  run(session(Renderer::kPenalty3, 800), make_box({0.1, 0.1, 0.1}), pressing, 0.2, {1, 0},
      [](const ServoFrame& f, const ContactSet*) {
        const double depth = std::max(0.0, 0.05 - f.X_WT.p.z);
        CAPTURE(f.tick, depth);
        REQUIRE_THAT(f.F_device_B.f, IsNear({0, 0, 800 * depth}, 1e-9));
      });
}

TEST_CASE("penalty: artefact 1, the force turns by 90 degrees at the bisector", "[lab][trap]") {
  // k = 1 N/mm, 2 mm deep in both faces: |ΔF| = √2·k·d = 2.83 N
  const auto penalty = run_artefact(ArtefactScene::kEdge, Renderer::kPenalty3);
  CHECK(penalty.largest_step() == Approx(std::sqrt(2.0) * 1000 * 2e-3).epsilon(2e-3));
  CHECK(penalty.force_W.front().z > 1.9);
  CHECK(penalty.force_W.back().x > 1.4);
  CHECK(penalty.force_W.back().z == 0);

  // a proxy that entered through the top stays there: |ΔF| ≤ k·|Δtool|
  const Renderer renderer = GENERATE(Renderer::kGodObject3, Renderer::kVirtualProxy3);
  const auto proxy = run_artefact(ArtefactScene::kEdge, renderer);
  CHECK(proxy.largest_step(1000) <= tol(1e-9));
  CHECK(proxy.force_W.back().z > 1.9);
}

TEST_CASE("penalty: artefact 2, a thin plate lets the tool pop through", "[lab][trap]") {
  // plate of 4 mm, k = 400 N/m: at most k·w/2 = 0.80 N resist; past the middle the force helps; 2
  // mm beyond the far face no force, or −2.4 N with the god-object
  const auto penalty = run_artefact(ArtefactScene::kPlate, Renderer::kPenalty3);
  CHECK(penalty.most_along({0, 0, 1}) == Approx(0.80).epsilon(0.03));
  CHECK(penalty.most_along({0, 0, -1}) == Approx(0.80).epsilon(0.03));
  CHECK(penalty.force_W.back().z == 0);

  const Renderer renderer = GENERATE(Renderer::kGodObject3, Renderer::kVirtualProxy3);
  const auto proxy = run_artefact(ArtefactScene::kPlate, renderer);
  CHECK(proxy.force_W.back().z == Approx(400 * 0.006).epsilon(1e-9));
  CHECK(proxy.most_along({0, 0, -1}) == 0);
}

TEST_CASE("penalty: the measured artefacts are those of theory", "[lab]") {
  const Rows rows;
  eval_artefacts("", rows);
  for (const Row& row : rows.rows()) {
    CAPTURE(row.case_name, row.metric, row.value);
    CHECK(row.holds.value_or(true));
  }
}

TEST_CASE("penalty: another renderer takes over while the session runs, softly", "[lab]") {
  // from the penalty force to the god-object and on to a sphere, the hand pressed in by 5 mm
  SessionConfig config = session(Renderer::kPenalty3, 800);
  config.safety.soft_start = 0.2;
  config.proxy_radius = 2e-3;
  const MeshShapeData owned = build_shape(make_box({0.1, 0.1, 0.1}));
  const std::array<MeshShape, 1> shapes{owned.view()};
  const ServoModel servo_model = build_servo_model(config, {1e3, 0});
  const ContactModel contact_model = build_contact_model(config, shapes);
  const auto contact = std::make_unique<ContactState>();
  ServoState servo;
  ControlFrame control = initial_control(config);
  control.armed = 1;
  ContactSet set{};
  double last = 0;
  for (uint64_t k = 0; k < 1500; ++k) {
    if (k == 500) control.renderer = static_cast<uint32_t>(Renderer::kGodObject3);
    if (k == 1000) control.renderer = static_cast<uint32_t>(Renderer::kVirtualProxy3);
    ServoInput input;
    input.tick = k;
    input.t_ns = static_cast<int64_t>(1'000'000'000 + k * 1'000'000);
    input.device.t_ns = input.t_ns;
    input.device.flags = kDeviceFresh | kDeviceHomed;
    input.device.X_BH.p = {0.01, 0.02, 0.045};
    input.contacts = k > 0 ? &set : nullptr;
    input.control = &control;
    const ServoFrame f = servo_step(servo_model, servo, input);
    set = contact_step(contact_model, *contact, f, nullptr);
    CAPTURE(k, last, f.F_device_B.f);
    // only the switch itself may step down; increases are ramps
    REQUIRE(f.F_device_B.f.z - last <= 7e-3 * 800 / 200 + 1e-9);
    last = f.F_device_B.f.z;
    if (k == 499 || k == 999) REQUIRE(last == Approx(800 * 0.005));
  }
  CHECK(set.renderer == static_cast<uint32_t>(Renderer::kVirtualProxy3));
  CHECK(last == Approx(800 * 0.007));
}
