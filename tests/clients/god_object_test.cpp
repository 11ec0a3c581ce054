// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer god-object3, servo and contact together in lockstep, against closed forms.
#include <random>

#include "clients/lockstep.h"
#include "contact/bake_inside.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"
#include "tests/support/workload.h"

using haptic::Lockstep;
using haptic::LockstepOptions;
using haptic::MeshShape;
using haptic::ServoFrame;
using haptic::SessionConfig;
using haptic::Vec3;
using haptic::test::IsNear;
using haptic::test::kPi;
using haptic::test::OwnedShape;
using haptic::test::plain_session;
using haptic::test::ScriptedHand;
using haptic::test::tol;

namespace {

constexpr double kForceRelative = 1e-9;  // the bound on force = k·depth
constexpr double kStiffness = 800;

/// Runs a scripted hand against one object and shows each frame to `see`.
void run(SessionConfig config, haptic::Soup soup, std::function<Vec3(double)> path, double seconds,
         const LockstepOptions& options,
         const std::function<void(const ServoFrame&, const MeshShape&)>& see) {
  const OwnedShape owned(std::move(soup));
  const std::array<MeshShape, 1> shapes{owned.view()};
  ScriptedHand hand(std::move(path));
  Lockstep lockstep(config, shapes, hand, options);
  const auto ticks = static_cast<int>(seconds * config.servo_rate);
  for (int k = 0; k < ticks; ++k) {
    REQUIRE(lockstep.step());
    see(lockstep.frame(), shapes[0]);
  }
}

Vec3 centroid(const haptic::TriangleMesh& mesh, size_t t) {
  const haptic::Triangle& v = mesh.triangles[t];
  return (mesh.vertices[v[0]] + mesh.vertices[v[1]] + mesh.vertices[v[2]]) / 3.0;
}

}  // namespace

TEST_CASE("god-object: plane force is k times depth with exact direction", "[lab]") {
  const uint32_t latency = GENERATE(0u, 1u, 2u);
  int touched = 0;
  // the top of a block is the plane z = 0
  SessionConfig config = plain_session(kStiffness);
  config.objects[0].X_WO.p.z = -0.1;
  run(config, haptic::make_box({0.4, 0.4, 0.2}), haptic::test::flat_slide, 2, {1, latency},
      [&](const ServoFrame& f, const MeshShape&) {
        const double depth = -f.X_WT.p.z;
        if (depth <= 0 || f.n_contacts == 0) return;
        ++touched;
        const double exact = kStiffness * depth;
        REQUIRE(std::fabs(f.F_device_B.f.z - exact) <= tol(kForceRelative) * exact);
        REQUIRE(f.F_device_B.f.x == 0);
        REQUIRE(f.F_device_B.f.y == 0);
      });
  CHECK(touched > 1500);
}

TEST_CASE("god-object: sphere force is k times depth along the facet's normal", "[lab]") {
  // pressed in through the middle of each facet: the exact answer is the facet's plane
  const double radius = 0.05;
  const OwnedShape owned(haptic::make_icosphere(radius, 2));
  const auto mesh = owned.view().mesh;
  const std::array<MeshShape, 1> shapes{owned.view()};
  const double sagitta = radius - norm(centroid(mesh, 0));
  for (size_t t = 0; t < mesh.triangles.size(); t += 7) {
    const Vec3 middle = centroid(mesh, t);
    const Vec3 n = mesh.face_normals[t];
    ScriptedHand hand([&](double time) { return middle + (0.004 - 0.05 * time) * n; });
    Lockstep lockstep(plain_session(kStiffness), shapes, hand);
    for (int k = 0; k < 200; ++k) {
      REQUIRE(lockstep.step());
      const ServoFrame& f = lockstep.frame();
      const double depth = dot(middle - f.X_WT.p, n);
      if (depth <= 0 || f.n_contacts == 0) continue;
      const double exact = kStiffness * depth;
      REQUIRE(norm(f.F_device_B.f - exact * n) <= tol(kForceRelative) * exact);
      // and the smooth sphere's force within the facet error
      const double smooth = kStiffness * (radius - norm(f.X_WT.p));
      REQUIRE(std::fabs(norm(f.F_device_B.f) - smooth) <= kStiffness * 2 * sagitta);
    }
    CHECK(lockstep.frame().n_contacts == 1);
  }
}

TEST_CASE("god-object: no ripple on the frictionless flat slide", "[lab][trap]") {
  // 5,000 coplanar triangles: |ΔF − ΔF_exact| per tick ≤ 1e-5 N
  const uint32_t latency = GENERATE(0u, 1u);
  SessionConfig config = plain_session(1000);
  double last = 0, last_exact = 0, worst = 0;
  int compared = 0;
  run(config, haptic::make_grid(0.1, 50), haptic::test::flat_slide, 20, {1, latency},
      [&](const ServoFrame& f, const MeshShape&) {
        const double exact = 1000 * std::max(0.0, -f.X_WT.p.z);
        const double force = f.F_device_B.f.z;
        // from the first tick of full contact on
        if (f.tick > 500) {
          worst = std::max(worst, std::fabs((force - last) - (exact - last_exact)));
          worst = std::max(worst, norm(f.F_device_B.f - Vec3{0, 0, force}));
          ++compared;
        }
        last = force, last_exact = exact;
      });
  CHECK(compared == 19499);
  CHECK(worst <= tol(1e-5));
}

TEST_CASE("god-object: sliding over a convex edge never drops through and never pulls", "[lab]") {
  SessionConfig config = plain_session(kStiffness);
  const auto over_the_edge = [](double t) {
    const double x = 0.03 + 0.04 * t;  // off the top face at x = 0.05, 2 mm deep
    return Vec3{x, 0.001, 0.05 - 0.002 * std::min(1.0, t / 0.2)};
  };
  const OwnedShape block(haptic::make_box({0.1, 0.1, 0.1}));
  const haptic::InsideOracle oracle(block.view().mesh);
  run(config, haptic::make_box({0.1, 0.1, 0.1}), over_the_edge, 1, {},
      [&](const ServoFrame& f, const MeshShape&) {
        if (f.tick > 0) REQUIRE_FALSE(oracle.inside(f.X_WG.p));
        REQUIRE(f.F_device_B.f.z >= 0);
        if (f.X_WT.p.x > 0.0512) REQUIRE(norm(f.F_device_B.f) == 0);
      });
}

TEST_CASE("god-object: past a convex edge at 0.5 m/s with contact at 50 Hz there is no ghost wall",
          "[lab][trap]") {
  SessionConfig config = plain_session(kStiffness);
  // 1 mm above the face, off the edge at x = 50 mm, then down past where the face's plane would be
  const auto fly_past = [](double t) {
    const double x = -0.04 + 0.5 * t;
    const double beyond = std::max(0.0, x - 0.052);
    return Vec3{x, 0.003, 0.051 - 1.0 * beyond};
  };
  const uint32_t offset = GENERATE(take(5, random(0u, 19u)));
  double lowest = 1;
  run(
      config, haptic::make_box({0.1, 0.1, 0.1}),
      [&](double t) { return fly_past(t - 1e-3 * offset); }, 0.25, {20, 20},
      [&](const ServoFrame& f, const MeshShape&) {
        lowest = std::min(lowest, f.X_WT.p.z);
        REQUIRE(norm(f.F_device_B.f) == 0);
      });
  CHECK(lowest < 0.045);
}

TEST_CASE("god-object: a closed loop pressed into one face returns no energy", "[lab][property]") {
  // quasi-static, frictionless: ∮F·dx = 0 ± 1e-6 J
  SessionConfig config = plain_session(kStiffness);
  config.objects[0].X_WO.p.z = -0.05;
  const auto circle = [](double t) {
    const double a = 2 * kPi * t / 2.0;
    return Vec3{0.01 * std::cos(a), 0.01 * std::sin(a), -0.002 - 0.001 * std::sin(3 * a)};
  };
  double work = 0;
  Vec3 last_p, last_f;
  int k = 0;
  run(config, haptic::make_box({0.2, 0.2, 0.1}), circle, 4.001, {},
      [&](const ServoFrame& f, const MeshShape&) {
        // trapezoid over the second turn
        if (k > 2000) work += dot(0.5 * (f.F_device_B.f + last_f), f.X_WT.p - last_p);
        last_p = f.X_WT.p, last_f = f.F_device_B.f;
        ++k;
      });
  CHECK(std::fabs(work) <= tol(1e-6));
}

TEST_CASE("god-object: verified proxy is never inside, on a rough random walk", "[lab][property]") {
  const uint32_t latency = GENERATE(0u, 1u, 10u);
  const OwnedShape sphere(haptic::make_icosphere(0.03, 4));
  const haptic::InsideOracle oracle(sphere.view().mesh);
  int pressed = 0;
  run(
      plain_session(kStiffness), haptic::make_icosphere(0.03, 4),
      [](double t) {
        return (0.028 + 0.008 * std::sin(9 * t)) *
               haptic::normalized(
                   Vec3{std::sin(3.1 * t), std::cos(2.3 * t), std::sin(1.7 * t + 1)});
      },
      5, {1, latency},
      [&](const ServoFrame& f, const MeshShape&) {
        pressed += f.n_contacts > 0;
        if ((f.flags & haptic::kServoNoContactSet) == 0) REQUIRE_FALSE(oracle.inside(f.X_WG.p));
        REQUIRE(is_finite(f.F_device_B));
      });
  CHECK(pressed > 2000);
}

TEST_CASE("god-object: a moving block at 1 m/s pushes the proxy, no pop-through", "[lab][trap]") {
  SessionConfig config = plain_session(kStiffness);
  config.objects[0].motion.kind = haptic::MotionKind::kOscillate;
  config.objects[0].motion.axis_O = {0, 0, 1};
  config.objects[0].motion.amplitude = 0.05;
  config.objects[0].motion.frequency = 1 / (2 * kPi * 0.05);  // peak speed 1 m/s
  config.objects[0].X_WO.p.z = -0.03;
  const OwnedShape plate(haptic::make_box({0.2, 0.2, 0.01}));
  const std::array<MeshShape, 1> shapes{plate.view()};
  ScriptedHand hand([](double) { return Vec3{}; });
  Lockstep lockstep(config, shapes, hand);
  for (int k = 0; k < 3000; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    if (lockstep.contacts() == nullptr) continue;
    const double top = lockstep.contacts()->X_WO[0].p.z + 0.005;
    REQUIRE(f.X_WG.p.z >= top);
  }
}

TEST_CASE("god-object: a hand that starts inside gets no kick", "[lab]") {
  SessionConfig config = plain_session(kStiffness);
  config.safety.soft_start = 0.5;
  double before = 0;
  run(
      config, haptic::make_box({0.1, 0.1, 0.1}),
      [](double) {
        return Vec3{0, 0, 0.045};
      },
      1, {},
      [&](const ServoFrame& f, const MeshShape&) {
        REQUIRE(norm(f.F_device_B.f) - before <= kStiffness * 0.005 / 500 + 1e-9);
        before = norm(f.F_device_B.f);
      });
  CHECK(before == Approx(kStiffness * 0.005).epsilon(1e-6));
}

TEST_CASE("god-object: a restarted contact takes the proxy up where the servo last saw it",
          "[lab]") {
  // a thin plate: seeding at the tool would put the proxy on the wrong side
  const OwnedShape plate(haptic::make_box({0.2, 0.2, 0.001}));
  const std::array<MeshShape, 1> shapes{plate.view()};
  SessionConfig config = plain_session(kStiffness);
  const haptic::ContactModel model = build_contact_model(config, shapes);
  auto first = std::make_unique<haptic::ContactState>();
  ServoFrame servo{};
  servo.flags = haptic::kServoNoContactSet;
  servo.X_WT.p = {0, 0, 0.01};
  servo.t_ns = 1;
  contact_step(model, *first, servo, nullptr);
  servo.X_WT.p = {0, 0, -0.01};
  const auto pressed = contact_step(model, *first, servo, nullptr);
  REQUIRE(pressed.X_WG.p.z > 0.0005);

  servo.X_WG = pressed.X_WG;
  servo.flags = 0;
  auto second = std::make_unique<haptic::ContactState>();
  const auto resumed = contact_step(model, *second, servo, nullptr);
  CHECK_THAT(resumed.X_WG.p, IsNear(pressed.X_WG.p, 1e-9));
  CHECK(resumed.n_active == 1);
}
