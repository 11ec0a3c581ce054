// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer virtual-proxy3, servo and contact together in lockstep, against closed forms.
// god_object_test.cpp tests what both renderers of a point do.
#include "clients/lockstep/lockstep.h"
#include "contact/bake/inside.h"
#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"
#include "tests/clients/lab/eval/scripted_run.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kVirtualStiffness = 800;

SessionConfig proxy_session(double radius, const MaterialConfig& material = {}) {
  SessionConfig config = plain_session(kVirtualStiffness);
  config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = radius;
  config.objects[0].material = material;
  return config;
}

/// Presses to `depth` over 50 ms; from 100 ms on `sideways` moves it.
std::function<Vec3(double)> press(double depth, double radius,
                                  std::function<Vec3(double)> sideways) {
  return [=](double t) {
    const Vec3 along = t > 0.1 ? sideways(t - 0.1) : Vec3{};
    return along + Vec3{0, 0, radius - depth * std::min(1.0, t / 0.05) + 1e-3 * (t < 1e-3)};
  };
}
std::function<Vec3(double)> press(double depth, double radius, const Vec3& velocity = {}) {
  return press(depth, radius, [velocity](double t) { return t * velocity; });
}

double tangential(const Vec3& f) {
  return std::hypot(f.x, f.y);
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

/// The largest rotation of the force per tick on a circle at constant depth in a sphere.
struct Circle {
  double largest_turn = 0;
  double largest_error = 0;  // of |F| against k·depth [N]
  double sagitta = 0;        // largest depth of the sphere below its facets [m]
};

Circle circle_on_sphere(double crease_angle, double radius) {
  MaterialConfig material;
  material.crease_angle = crease_angle;
  const double size = 0.05, depth = 2e-3;
  Circle out;
  const MeshShapeData ball = build_shape(make_icosphere(size, 4));
  for (size_t t = 0; t < ball.mesh.triangles.size(); ++t) {
    const Vec3& corner = ball.mesh.vertices[ball.mesh.triangles[t][0]];
    out.sagitta = std::max(out.sagitta, size - dot(ball.mesh.face_normals[t], corner));
  }
  Vec3 last;
  run(
      proxy_session(radius, material), make_icosphere(size, 4),
      [&](double t) {
        const double in = size + radius - depth * std::min(1.0, t / 0.05);
        const double a = 0.6 * t;
        return in * normalized(Vec3{std::cos(a), 0.3, std::sin(a)});
      },
      3, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick > 60) {
          out.largest_turn = std::max(out.largest_turn, angle_between(last, f.F_device_B.f));
          const double exact = kVirtualStiffness * depth;
          out.largest_error = std::max(out.largest_error, std::fabs(norm(f.F_device_B.f) - exact));
        }
        last = f.F_device_B.f;
      });
  return out;
}

}  // namespace

TEST_CASE("virtual proxy: effective stiffness is s_s times k exactly", "[lab]") {
  MaterialConfig soft;
  soft.stiffness_share = GENERATE(0.0, 0.25, 0.7, 1.0);
  const double radius = 1e-3;
  run(proxy_session(radius, soft), block_below(), press(3e-3, radius), 0.2, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick < 20) return;
        const double exact = soft.stiffness_share * kVirtualStiffness * (radius - f.X_WT.p.z);
        REQUIRE(std::fabs(f.F_device_B.f.z - exact) <= tol(1e-12));
      });
}

TEST_CASE("virtual proxy: it sticks up to the static cone, then the ratio is mu_d", "[lab]") {
  const double mu_s = 0.6, mu_d = 0.4;
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  const uint32_t latency = GENERATE(0u, 1u);
  bool slid = false;
  int stuck = 0, slides = 0;
  run(proxy_session(radius, rough(mu_s, mu_d)), block_below(), press(2e-3, radius, {0.01, 0, 0}),
      0.6, {1, latency}, [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick < 110) return;
        const Vec3 force = f.F_device_B.f;
        CAPTURE(f.tick, radius, force, f.X_WT.p, f.X_WP.p);
        REQUIRE(std::fabs(force.z - kVirtualStiffness * 2e-3) <= tol(1e-9));
        const double angle = f.X_WT.p.x / 2e-3;
        if (angle <= mu_s) {
          ++stuck;
          REQUIRE_THAT(f.X_WP.p, IsNear({0, 0, radius}, 1e-9));
        } else {
          slid = true;
          ++slides;
          REQUIRE(std::fabs(tangential(force) / force.z - mu_d) <= tol(0.01) * mu_d);
        }
      });
  CHECK(slid);
  CHECK(stuck > 100);
  CHECK(slides > 300);
}

TEST_CASE("virtual proxy: on a slope it sticks iff the tangent is below mu_s", "[lab]") {
  // the tool is pressed in along directions at an angle theta to the normal
  const double mu = 0.5;
  const double lean = GENERATE(0.4, 0.49, 0.51, 0.7);  // tan theta
  const double radius = 1e-3;
  double moved = 0, ratio = 0;
  run(
      proxy_session(radius, rough(mu, mu)), block_below(),
      [&](double t) {
        const double depth = 20e-3 * t - 1e-3;
        return Vec3{depth * lean, 0, radius - depth};
      },
      0.25, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick < 150) return;
        moved = std::max(moved, std::fabs(f.X_WP.p.x));
        ratio = tangential(f.F_device_B.f) / f.F_device_B.f.z;
      });
  CAPTURE(lean, moved, ratio);
  // the first touch is up to one tick of motion behind the surface
  CHECK((moved < 0.03e-3) == (lean < mu));
  CHECK(std::fabs(ratio - std::min(lean, mu)) <= tol(0.01) * mu);
}

TEST_CASE("virtual proxy: with viscous friction it creeps at (f_t - mu_d f_n)/b", "[lab]") {
  MaterialConfig m = rough(0.2, 0.2);
  m.friction_viscous = 20;
  const double radius = 1e-3, depth = 2e-3;
  // the tool moves sideways by 3 mm within 10 ms and stays
  double last_x = 0;
  int moving = 0;
  run(proxy_session(radius, m), block_below(),
      press(depth, radius,
            [](double t) {
              return 3e-3 * std::min(1.0, t / 0.01) * Vec3{1, 0, 0};
            }),
      0.4, {}, [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick > 111 && f.tick < 150) {
          ++moving;
          const double pull = kVirtualStiffness * (3e-3 - last_x - 0.2 * depth);
          REQUIRE(std::fabs((f.X_WP.p.x - last_x) - pull / 20 * 1e-3) <= tol(1e-9));
        }
        last_x = f.X_WP.p.x;
      });
  CHECK(moving > 30);
  CHECK(std::fabs(3e-3 - last_x - 0.2 * depth) < 1e-6);
}

TEST_CASE("virtual proxy: what sticks is not dragged off by the verified proxy", "[lab][trap]") {
  // on a curved surface: contact must search around the proxy, 3 mm from the foot of the hand; on
  // an edge, its own proxy may rest on either adjacent face, 4 mm · 0.05 rad away
  const uint32_t period = GENERATE(1u, 20u);
  const double radius = 1e-3, depth = 4e-3;
  Vec3 anchor;
  int stuck = 0;
  run(
      proxy_session(radius, rough(1, 1)), make_icosphere(0.05, 4),
      [&](double t) {
        const double aside = 3e-3 * std::clamp((t - 0.3) / 0.3, 0.0, 1.0);
        return Vec3{aside, 2e-4, 0.05 + radius - depth * std::min(1.0, t / 0.05)};
      },
      0.8, {period, period},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick == 299) anchor = f.X_WP.p;
        if (f.tick < 300) return;
        ++stuck;
        CAPTURE(f.tick, f.X_WT.p, f.X_WP.p, f.X_WG.p, anchor);
        REQUIRE(norm(f.X_WP.p - anchor) <= 20e-6);
        REQUIRE(norm(f.X_WG.p - anchor) <= 0.25e-3);
      });
  CHECK(stuck == 500);
}

TEST_CASE("virtual proxy: what sticks is carried by its object", "[lab][trap]") {
  // the plate moves sideways at up to 1 m/s under a hand at rest; the anchor moves with it
  SessionConfig config = proxy_session(1e-3, rough(5, 5));
  oscillate(config.objects[0], {1, 0, 0}, 2e-3);
  config.sim_rate = 1000;
  const MeshShapeData owned = build_shape(block_below());
  const std::array<MeshShape, 1> shapes{owned.view()};
  ScriptedHand hand(press(2e-3, 1e-3));
  Lockstep lockstep(config, shapes, hand, {});
  double anchor = 0;
  for (int k = 0; k < 500; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    const double x = f.X_WP.p.x - object_pose_at(lockstep.scene(), 0, f.t_ns).p.x;
    if (k == 100) anchor = x;
    if (k > 100) {
      CAPTURE(k, x, anchor);
      REQUIRE(std::fabs(x - anchor) <= tol(1e-4));
      REQUIRE(f.n_contacts > 0);
    }
  }
}

TEST_CASE("virtual proxy: shading of a sphere mesh turns the force at least 5 times less per tick",
          "[lab]") {
  const double radius = GENERATE(0.0, 1e-3);
  const Circle flat = circle_on_sphere(0, radius);
  const Circle shaded = circle_on_sphere(0.5, radius);
  CAPTURE(radius, flat.largest_turn, shaded.largest_turn, flat.largest_error, shaded.largest_error);
  CHECK(flat.largest_turn >= 5 * shaded.largest_turn);
  // |F| = k·d within the facet error, shaded or not
  CHECK(flat.largest_error <= 1.01 * kVirtualStiffness * flat.sagitta);
  CHECK(shaded.largest_error <= 1.01 * kVirtualStiffness * flat.sagitta);
}

TEST_CASE("virtual proxy: without shading a prism of ten sides turns the force by 36 degrees",
          "[lab]") {
  std::vector<Vec3> outline;
  for (int i = 0; i < 10; ++i) {
    outline.push_back({0.05 * std::cos(0.2 * kPi * i), 0.05 * std::sin(0.2 * kPi * i), 0});
  }
  const double crease = GENERATE(0.0, 0.7);
  MaterialConfig material;
  material.crease_angle = crease;
  double largest = 0;
  Vec3 last;
  run(
      proxy_session(0, material), make_prism(outline, 0.05),
      [](double t) {
        const double in = 0.049 - 0.004 * std::min(1.0, t / 0.05);
        return Vec3{in * std::cos(0.6 * t + 0.1), in * std::sin(0.6 * t + 0.1), 0.003};
      },
      2, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick > 100) largest = std::max(largest, angle_between(last, f.F_device_B.f));
        last = f.F_device_B.f;
      });
  CAPTURE(crease, largest);
  if (crease == 0) {
    CHECK(largest == Approx(kPi / 5).epsilon(5e-3));
  } else {
    CHECK(largest <= kPi / 5 / 5);
  }
}

TEST_CASE("virtual proxy: a crease keeps its edge", "[lab]") {
  // the edges of a box have 90 degrees, more than the crease angle: the force is that of the face
  MaterialConfig material;
  material.crease_angle = 0.7;
  run(
      proxy_session(1e-3, material), make_box({0.1, 0.1, 0.1}),
      [](double t) {
        return Vec3{0.045 * std::sin(3 * t), 0.02, 0.051 - 2e-3 * std::min(1.0, t / 0.1)};
      },
      1, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick < 10) return;
        REQUIRE(tangential(f.F_device_B.f) <= tol(1e-9));
      });
}

TEST_CASE("virtual proxy: a sine grating tilts the force by at most atan(2 pi a/lambda)", "[lab]") {
  // 0.1 mm at 2 mm: 17.4 degrees; at 50 mm/s it is felt at 25 Hz
  MaterialConfig material;
  material.texture = {TextureKind::kGrating, 0, 0.1e-3, 2e-3, {1, 0, 0}};
  const double radius = 1e-3;
  double largest = 0, last = 0;
  int crossings = 0;
  run(proxy_session(radius, material), block_below(), press(2e-3, radius, {0.05, 0, 0}), 1.1, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick <= 100) return;
        const Vec3 force = f.F_device_B.f;
        REQUIRE(std::fabs(force.z - kVirtualStiffness * 2e-3) <= tol(1e-9));
        largest = std::max(largest, std::atan(std::fabs(force.x) / force.z));
        crossings += last < 0 && force.x >= 0;
        last = force.x;
      });
  CHECK(largest == Approx(std::atan(0.1 * kPi)).epsilon(1e-3));
  CHECK(largest * 180 / kPi == Approx(17.4).margin(0.1));
  CHECK(crossings == Approx(25).margin(1));
}

TEST_CASE("virtual proxy: a line finer than the way of a tick is felt each time", "[lab][trap]") {
  // one bright pixel row of 0.3 mm in a tile of 10 mm, crossed at 1 m/s: 1 mm a tick
  SessionConfig config = proxy_session(1e-3);
  config.n_images = 1;
  HeightImage& image = config.images[0];
  image.width = 32;
  image.height = 1;
  image.grey[10] = 255;
  config.objects[0].material.texture = {TextureKind::kImage, 0, 0.1e-3, 10e-3, {}};
  std::array<bool, 10> felt{};
  run(config, block_below(), press(2e-3, 1e-3, {1, 0, 0}), 0.2, {},
      [&](const ServoFrame& f, const ContactSet*) {
        if (f.tick <= 102) return;
        const auto tile = static_cast<size_t>(f.X_WT.p.x / 10e-3);
        if (tile < felt.size()) felt[tile] |= std::fabs(f.F_device_B.f.x) > 0.1 * f.F_device_B.f.z;
      });
  CHECK(std::count(felt.begin(), felt.end(), true) >= 9);
}

TEST_CASE(
    "virtual proxy: an object at 1 m/s does not pass through, and the contact is within 0.1 mm",
    "[lab][trap]") {
  const uint32_t period = GENERATE(1u, 5u, 20u);
  const double radius = 1e-3;
  SessionConfig config = proxy_session(radius);
  oscillate(config.objects[0], {0, 0, 1}, 0.05);
  config.objects[0].X_WO.p.z = -0.03;
  config.sim_rate = 1000;
  const MeshShapeData plate = build_shape(make_box({0.2, 0.2, 0.01}));
  const std::array<MeshShape, 1> shapes{plate.view()};
  ScriptedHand hand([](double) { return Vec3{}; });
  Lockstep lockstep(config, shapes, hand, {period, period});
  int pressed = 0;
  double worst = 0;
  for (int k = 0; k < 3000; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    const double true_top =
        -0.03 + 0.05 * std::sin((static_cast<double>(f.t_ns) * 1e-9 - 1) / 0.05) + 0.005;
    if (f.tick < 200) continue;  // the first contacts fade in
    const double depth = true_top + radius;
    CAPTURE(k, period, depth, f.X_WP.p.z, f.n_contacts);
    // if it comes faster than the look-ahead of a slow contact, the first touch may be late
    if (depth > 1e-3 * (period + 1)) {
      ++pressed;
      REQUIRE(f.n_contacts > 0);
      worst = std::max(worst, std::fabs(f.X_WP.p.z - depth));
    }
    if (depth < -1e-4) REQUIRE(norm(f.F_device_B.f) == 0);
  }
  CAPTURE(period, worst);
  CHECK(pressed > 400);
  CHECK(worst <= 1e-4);
}

TEST_CASE("virtual proxy: a plate that turns at 1 m/s under the tool does not pass through",
          "[lab][trap]") {
  const double radius = GENERATE(0.0, 1e-3);
  SessionConfig config = proxy_session(radius);
  config.objects[0].motion.kind = MotionKind::kSpin;
  config.objects[0].motion.axis_O = {1, 0, 0};
  config.objects[0].motion.frequency = 1 / (2 * kPi * 0.054);
  config.sim_rate = 1000;
  const double half = 0.5e-3;
  const MeshShapeData plate = build_shape(make_box({0.3, 0.3, 2 * half}));
  const std::array<MeshShape, 1> shapes{plate.view()};
  // 54 mm from the axis, in front of the plate for half a turn and behind it for the other half
  ScriptedHand hand([](double) { return Vec3{0.01, 0.05, 0.02}; });
  Lockstep lockstep(config, shapes, hand);
  int pressed = 0, passes = 0;
  double worst = 0, before = 1;
  for (int k = 0; k < 1000; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    const auto height_over = [](const Pose& X_WO, const Vec3& p_W) {
      return (inverse(X_WO) * p_W).z;
    };
    const Pose X_WO = object_pose_at(lockstep.scene(), 0, f.t_ns);
    const double height = height_over(X_WO, f.X_WT.p);
    CAPTURE(k, radius, height, f.X_WG.p, f.X_WP.p);
    passes += before > 0 && height <= 0;
    before = height;
    if ((f.flags & kServoNoContactSet) != 0) continue;
    // always on the side it came from
    REQUIRE(height_over(lockstep.contacts()->objects[0].X_WO, f.X_WG.p) >= half + radius);
    if (height > radius - 2e-3) continue;
    ++pressed;
    worst = std::max(worst, std::fabs(height_over(X_WO, f.X_WP.p) - half - radius));
  }
  CAPTURE(radius, worst);
  CHECK(passes >= 2);
  CHECK(pressed > 400);
  CHECK(worst <= 1e-4);
}

TEST_CASE("virtual proxy: with contact throttled to 50 Hz the surface is sticky, never unstable",
          "[lab]") {
  // a mass on a spring, held by a damped hand, falls onto the surface and comes to rest
  const uint32_t period = GENERATE(1u, 5u, 10u, 20u);
  const double radius = GENERATE(0.0, 1e-3);
  const double mu = GENERATE(0.0, 0.5);
  SessionConfig config = proxy_session(radius, rough(mu, mu));
  config.device.kind = DeviceKind::kSimulatedHand;
  config.device.max_force = 50;
  config.safety.max_force = 50;
  config.device.hand.intent.hover_radius = 0.05;
  config.device.hand.intent.press_radius = 0.02;
  config.device.hand.intent.direction_B = {0.3, 0.2, 0.9};
  config.device.hand.intent.stroke_time = 2;
  const MeshShapeData ball = build_shape(make_icosphere(0.03, 4));
  const std::array<MeshShape, 1> shapes{ball.view()};
  const InsideOracle oracle(ball.view().mesh);
  const auto device = open_device(config.device);
  Lockstep lockstep(config, shapes, *device, {period, period});
  double peak = 0, ripple = 0, last = 0;
  int pressed = 0;
  for (int k = 0; k < 4000; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    const double force = norm(f.F_device_B.f);
    peak = std::max(peak, force);
    pressed += f.n_contacts > 0;
    if (k > 2 * static_cast<int>(period)) ripple = std::max(ripple, std::fabs(force - last));
    last = force;
    REQUIRE(is_finite(f.F_device_B));
    if ((f.flags & kServoNoContactSet) == 0) REQUIRE_FALSE(oracle.inside(f.X_WG.p));
  }
  CAPTURE(period, radius, mu, peak, ripple, pressed);
  // the deepest spring force: the intention is 10 mm below the surface, the hand 300 N/m
  CHECK(pressed > 1000);
  CHECK(peak < 4);
  CHECK(ripple < 0.3);
}
