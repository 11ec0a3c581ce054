// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/solve/point/friction.cpp, shading.cpp, texture.cpp and direct.cpp.
#include <memory>

#include "servo/solve/point/direct.h"
#include "servo/solve/point/friction.h"
#include "servo/solve/point/shading.h"
#include "servo/solve/point/texture.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

const haptic::TickScene kAtOrigin = [] {
  haptic::TickScene scene;
  scene.X_WO.resize(1);
  scene.V_WO.resize(1);
  return scene;
}();

std::unique_ptr<ContactSet> planes_through(std::initializer_list<Vec3> normals) {
  auto set = std::make_unique<ContactSet>();
  *set = {};
  for (const Vec3& n : normals) {
    Contact c{};
    c.normal_O = c.shading_normal_O = n;
    c.extent = 1;
    set->contacts.push_back(c);
  }
  return set;
}

HeightImage ramp_image() {
  HeightImage image;
  image.width = 8, image.height = 4;
  for (uint32_t i = 0; i < 32; ++i) image.grey[i] = static_cast<uint8_t>(37 * i % 256);
  return image;
}

/// Height of the bilinear image by its definition, for finite differences.
double image_height(const HeightImage& image, double x, double y) {
  const auto at = [&](double i, double j) {
    const auto column = static_cast<uint32_t>(std::fmod(i + 800, 8)),
               row = static_cast<uint32_t>(std::fmod(j + 400, 4));
    return static_cast<double>(image.grey.at(row * image.width + column));
  };
  const double i = std::floor(x), j = std::floor(y), u = x - i, v = y - j;
  return (1 - u) * (1 - v) * at(i, j) + u * (1 - v) * at(i + 1, j) + (1 - u) * v * at(i, j + 1) +
         u * v * at(i + 1, j + 1);
}

}  // namespace

TEST_CASE("friction: on a random way the force stays in the static cone", "[servo][property]") {
  Random random(3);
  const FrictionLaw law{0.6, 0.4, 0, 800, 1e-3};
  FrictionState state;
  Vec3 tool{0, 0, -1e-3};
  for (int k = 0; k < 20000; ++k) {
    tool += 0.2e-3 * random.direction();
    tool.z = -std::fabs(tool.z);
    const Vec3 foot{tool.x, tool.y, 0};
    const Vec3 proxy = hold_by_friction(law, state, tool, foot, 0, {});
    CAPTURE(k, tool, proxy);
    REQUIRE(proxy.z == 0);
    REQUIRE(std::hypot(proxy.x - tool.x, proxy.y - tool.y) <= -tool.z * 0.6 * (1 + tol(1e-12)));
  }
}

TEST_CASE("friction: viscous alone creeps at f_t/b, from no cone", "[servo]") {
  // each tick makes up k dt/b of the distance: 3 mm sideways leave 3 mm (1 − 0.04)^n
  const FrictionLaw law{0, 0, 20, 800, 1e-3};
  FrictionState state;
  hold_by_friction(law, state, {0, 0, -1e-3}, {}, 0, {});
  double left = 3e-3;
  for (int n = 0; n < 100; ++n) {
    const Vec3 proxy = hold_by_friction(law, state, {3e-3, 0, -1e-3}, {3e-3, 0, 0}, 0, {});
    left *= 1 - 0.04;
    REQUIRE_THAT(proxy, IsNear({3e-3 - left, 0, 0}, 1e-15));
  }
}

TEST_CASE("friction: the anchor is the object's", "[servo][trap]") {
  const FrictionLaw law{1, 1, 0, 800, 1e-3};
  FrictionState state;
  hold_by_friction(law, state, {0, 0, -1e-3}, {0, 0, 0}, 2, {});
  const Pose moved{{0.3e-3, 0.4e-3, 0}, {}};
  CHECK_THAT(hold_by_friction(law, state, {0, 0, -1e-3}, {0, 0, 0}, 2, moved),
             IsNear({0.3e-3, 0.4e-3, 0}, 1e-15));
  // another object begins without an anchor
  CHECK_THAT(hold_by_friction(law, state, {0, 0, -1e-3}, {0, 0, 0}, 1, moved), IsNear({}, 1e-15));
}

TEST_CASE("friction: the hysteresis between sliding and sticking", "[servo]") {
  const FrictionLaw law{0.8, 0.5, 0, 800, 1e-3};
  FrictionState state;
  const auto proxy_x = [&](double x) {
    return hold_by_friction(law, state, {x, 0, -1}, {x, 0, 0}, 0, {}).x;
  };
  CHECK(proxy_x(0) == 0);
  CHECK(proxy_x(0.79) == 0);             // sticks
  CHECK(proxy_x(0.81) == Approx(0.31));  // slips to the dynamic cone
  CHECK(proxy_x(0.9) == Approx(0.40));   // and keeps sliding
  CHECK(proxy_x(0.75) == Approx(0.40));  // back a little: still the dynamic coefficient
  CHECK(proxy_x(0.95) == Approx(0.45));
  CHECK(proxy_x(0.6) == Approx(0.45));  // below 0.6 of it: sticks again
  CHECK(proxy_x(1.2) == Approx(0.45));
  CHECK(proxy_x(1.3) == Approx(0.80));
}

TEST_CASE("shading: with one plane the force points along the shading normal exactly", "[servo]") {
  Random random(5);
  for (int k = 0; k < 500; ++k) {
    const Vec3 n = random.direction();
    const Vec3 m = normalized(n + random.uniform(0, 0.9) * cross(n, random.direction()));
    const Vec3 tool = -random.uniform(1e-4, 5e-3) * n + 0.1 * cross(n, random.direction());
    const auto set = planes_through({n});
    PlanesInForce planes;
    const PointProxySolution s = solve_point_proxy({*set, kAtOrigin, tool, 0, {}}, planes);
    const Vec3 proxy = shaded_proxy(s, planes, tool, {m, {}, {}});
    CAPTURE(n, m, tool);
    REQUIRE(std::fabs(dot(n, proxy)) <= tol(1e-15));
    REQUIRE_THAT(normalized(proxy - tool), IsNear(m, 1e-11));
  }
}

TEST_CASE("shading: it stays on the free side in a corner, and leans by 45 degrees at most",
          "[servo]") {
  const auto set = planes_through({{1, 0, 0}, {0, 1, 0}});
  const Vec3 tool{-1e-3, -2e-3, 0};
  PlanesInForce planes;
  const PointProxySolution s = solve_point_proxy({*set, kAtOrigin, tool, 0, {}}, planes);
  const Vec3 lean = haptic::normalized(Vec3{1, 0.4, 0.2});
  const Vec3 proxy = shaded_proxy(s, planes, tool, {lean, {0, 1, 0}, {}});
  CHECK(proxy.x >= -tol(1e-15));
  CHECK(proxy.y >= -tol(1e-15));

  const auto floor = planes_through({{0, 0, 1}});
  const PointProxySolution flat =
      solve_point_proxy({*floor, kAtOrigin, {0, 0, -1e-3}, 0, {}}, planes);
  const Vec3 steep = shaded_proxy(flat, planes, {0, 0, -1e-3}, {Vec3{1, 0, 0}, {}, {}});
  CHECK_THAT(steep, IsNear({1e-3, 0, 0}, 1e-12));
}

TEST_CASE("texture: the gradient is that of the height by finite differences", "[servo]") {
  const std::array<HeightImage, 1> images{ramp_image()};
  const TextureConfig grating{TextureKind::kGrating, 0, 1e-4, 2e-3, {0.6, 0.8, 0}};
  const TextureConfig picture{TextureKind::kImage, 0, 1e-3, 8e-3, {}};
  Random random(9);
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = random.in_box({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02});
    const Vec3 g = height_gradient(grating, images, p, {0, 0, 1});
    const auto h = [&](const Vec3& q) {
      return 1e-4 * std::sin(2 * 3.14159265358979323846 * (0.6 * q.x + 0.8 * q.y) / 2e-3);
    };
    const double step = 1e-8;
    REQUIRE(std::fabs(g.x - (h(p + Vec3{step, 0, 0}) - h(p - Vec3{step, 0, 0})) / (2 * step)) <
            tol(1e-6));
    REQUIRE(std::fabs(g.y - (h(p + Vec3{0, step, 0}) - h(p - Vec3{0, step, 0})) / (2 * step)) <
            tol(1e-6));

    // one pixel is 1 mm; away from the seams, where the slope jumps
    const double x = p.x / 1e-3, y = p.y / 1e-3;
    if (std::fabs(x - std::round(x)) < 1e-3 || std::fabs(y - std::round(y)) < 1e-3) continue;
    const Vec3 slope = height_gradient(picture, images, p, {0.1, 0.2, -0.9});
    const auto image = [&](double i, double j) { return image_height(images[0], i, j) / 255; };
    REQUIRE(slope.z == 0);
    REQUIRE(std::fabs(slope.x - (image(x + 1e-5, y) - image(x - 1e-5, y)) / 2e-5) < tol(1e-6));
    REQUIRE(std::fabs(slope.y - (image(x, y + 1e-5) - image(x, y - 1e-5)) / 2e-5) < tol(1e-6));
  }
}

TEST_CASE("texture: the steepest place on the way counts, not the last", "[servo][trap]") {
  HeightImage line;
  line.width = 32, line.height = 1;
  line.grey[10] = 255;
  const std::array<HeightImage, 1> images{line};
  const TextureConfig texture{TextureKind::kImage, 0, 1e-3, 32e-3, {}};
  const Vec3 before{5e-3, 0, 0}, after{15e-3, 0, 0};
  CHECK(height_gradient(texture, images, after, {0, 0, 1}) == Vec3{});
  CHECK(norm(steepest_gradient(texture, images, {before, after, {0, 0, 1}})) == Approx(1));
}

TEST_CASE("direct: forces of several objects add, planes in front of the tool give none",
          "[servo]") {
  const auto set = planes_through({{0, 0, 1}, {1, 0, 0}, {0, 1, 0}});
  const PointProxySolution s = haptic::solve_direct({*set, kAtOrigin, {-2e-3, 5e-3, -1e-3}, 0, {}});
  CHECK(s.n_active == 2);
  CHECK_THAT(s.proxy_W, IsNear({0, 5e-3, 0}, 1e-15));
}
