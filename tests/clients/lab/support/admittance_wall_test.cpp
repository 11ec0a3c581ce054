// SPDX-License-Identifier: GPL-3.0-or-later
// The commanded pose of an admittance device never enters a fixed wall, whatever the hand does;
// servo, contact and arm in lockstep, judged in closed form against the wall.
#include <numbers>

#include "contact/shape/mesh/primitives.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/arm_session.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRounding = 1e-12;  // [m]
constexpr double kHalf = 0.05;       // of the block [m]

/// Depth of a point in the block, from its planes; negative outside.
double depth_in_block(const Vec3& p) {
  return std::min({kHalf - std::fabs(p.x), kHalf - std::fabs(p.y), kHalf - std::fabs(p.z)});
}

const Vec3 kTool{0.01, 0.015, 0.02};  // half the box of the tool [m]

/// Depth of the tool in the block by the separating axes of two boxes; negative: a gap.
double depth_of_box(const Pose& X) {
  const Mat3 R = to_matrix(X.q);
  const std::array<Vec3, 3> a{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const std::array<Vec3, 3> b{R.column(0), R.column(1), R.column(2)};
  double least = 1e9;
  const auto try_axis = [&](const Vec3& axis) {
    if (norm(axis) < 1e-6) return;
    const Vec3 n = normalized(axis);
    double reach = 0;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<size_t>(i);
      reach += kHalf * std::fabs(dot(n, a[k])) + kTool[i] * std::fabs(dot(n, b[k]));
    }
    least = std::min(least, reach - std::fabs(dot(n, X.p)));
  };
  for (const Vec3& u : a) try_axis(u);
  for (const Vec3& v : b) try_axis(v);
  for (const Vec3& u : a) {
    for (const Vec3& v : b) try_axis(cross(u, v));
  }
  return least;
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = normalized(cross(b - a, c - a));
  const auto inside = [&](const Vec3& u, const Vec3& v) {
    return dot(cross(v - u, p - u), n) >= 0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::fabs(dot(n, p - a));
  const auto to_edge = [&](const Vec3& u, const Vec3& v) {
    const double share = std::clamp(dot(p - u, v - u) / norm_squared(v - u), 0.0, 1.0);
    return norm(p - u - share * (v - u));
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

/// Depth of a sphere of that radius in a convex mesh, where its planes do not already say that it
/// is outside.
double depth_in_convex(const TriangleMesh& mesh, const Vec3& p, double radius) {
  double out = -1e9, nearest = 1e9;
  const auto corner = [&](size_t t, size_t i) { return mesh.vertices[mesh.triangles[t][i]]; };
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = corner(t, 0);
    out = std::max(out, dot(normalized(cross(corner(t, 1) - a, corner(t, 2) - a)), p - a));
  }
  if (out < 0) return radius - out;
  if (out >= radius) return radius - out;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    nearest = std::min(nearest, distance_to_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2)));
  }
  return radius - nearest;
}

/// A hand that means to go about wildly: from place to place, at rest in between, in steps as
/// large as the arm; through the object as well as beside it.
Intention restless(uint64_t seed, double reach, double period, double turn = 0) {
  return [=](double t) {
    const auto place = [&](uint64_t i) {
      Random random(seed * 1000 + i);
      const Pose X{reach * random.uniform(0, 1) * random.direction(),
                   from_rotation_vector(turn * random.uniform(0, 1) * random.direction())};
      return X;
    };
    const double s = std::max(t, 0.0) / period;
    const auto i = static_cast<uint64_t>(s);
    // a slide to the next place, then a rest; every third place is jumped to
    if (i == 0) return Intent{{0, 0, 0.12}, {}, {}, {}};
    const double x = i % 3 == 0 ? 1 : std::min(2 * (s - static_cast<double>(i)), 1.0);
    const Pose from = i == 1 ? Pose{{0, 0, 0.12}, {}} : place(i - 1), to = place(i);
    Intent intent;
    intent.p_B = from.p + x * (to.p - from.p);
    intent.q_B = slerp(from.q, to.q, x);
    return intent;
  };
}

struct Deepest {
  double depth = -1;
  double hardest = 0, hardest_turn = 0;  // of the hand [N, N·m]
  int touching = 0;
};

template <class Depth>
Deepest run_into(SessionConfig config, const std::vector<Soup>& soups, const Intention& intention,
                 int ticks, const Depth& depth_of) {
  ArmRun run(config, soups, intention);
  Deepest out;
  for (int k = 0; k < ticks; ++k) {
    const ServoFrame& f = run.step();
    CAPTURE(k, f.flags);
    REQUIRE(f.fault == 0);
    const double depth = depth_of(tool_pose(config.map, {}, f.X_command_B));
    if (depth > kRounding && depth > out.depth) {
      UNSCOPED_INFO("tick " << k << " depth " << depth << " contacts " << f.n_contacts);
    }
    out.depth = std::max(out.depth, depth);
    out.hardest = std::max(out.hardest, norm(f.F_device_B.f));
    out.hardest_turn = std::max(out.hardest_turn, norm(f.F_device_B.t));
    out.touching += (f.flags & kServoContact) != 0;
  }
  return out;
}

SessionConfig strong_arm(Renderer renderer) {
  SessionConfig config = arm_session(renderer);
  config.device.hand.hand_stiffness = 2000;
  config.device.hand.hand_damping = 30;
  config.device.hand.hand_rotational_stiffness = 20;
  config.device.hand.hand_rotational_damping = 0.1;
  config.device.hand.hand_inertia = 1e-3;
  return config;
}

/// A point and a block, sticky and soft where asked for.
Deepest point_at_block(Renderer renderer, uint64_t seed, bool is_rough, int ticks) {
  SessionConfig config = strong_arm(renderer);
  config.proxy_radius = 0;
  if (is_rough) {
    config.objects[0].material.friction_static = 0.6;
    config.objects[0].material.friction_dynamic = 0.4;
    config.objects[0].material.stiffness_share = 0.5;
  }
  return run_into(config, {make_box({0.1, 0.1, 0.1})}, restless(seed, 0.15, 0.15), ticks,
                  [](const Pose& X) { return depth_in_block(X.p); });
}

/// A point or a sphere, and a round mesh.
Deepest ball_at_mesh(Renderer renderer, uint64_t seed, int ticks) {
  SessionConfig config = strong_arm(renderer);
  const Soup soup = make_icosphere(0.06, 3);
  const MeshShapeData shape = build_shape(soup);
  const TriangleMesh mesh = shape.mesh.view();
  config.proxy_radius = 2e-3;
  // a point does not mind the radius
  const double radius = renderer == Renderer::kVirtualProxy3 ? config.proxy_radius : 0;
  return run_into(config, {soup}, restless(seed, 0.12, 0.15), ticks,
                  [&](const Pose& X) { return depth_in_convex(mesh, X.p, radius); });
}

/// A rigid box and a block.
Deepest box_at_block(Renderer renderer, uint64_t seed, double friction, int ticks) {
  SessionConfig config = strong_arm(renderer);
  config.tool.mass = 0.05;
  config.device.admittance.inertia = 2e-3;
  config.objects[0].material.friction_static = config.objects[0].material.friction_dynamic =
      friction;
  const std::vector<Soup> soups{make_box({0.1, 0.1, 0.1}), make_box({2 * kTool})};
  return run_into(config, soups, restless(seed, 0.12, 0.2, 1), ticks, depth_of_box);
}

}  // namespace

TEST_CASE("admittance: a point never enters a block", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject3, Renderer::kVirtualProxy3);
  const uint64_t seed = GENERATE(1u, 2u);
  const bool is_rough = renderer == Renderer::kVirtualProxy3 && seed == 2;
  const Deepest found = point_at_block(renderer, seed, is_rough, 25000);
  CAPTURE(row_of(renderer).name, seed, found.hardest, found.touching, found.depth);
  CHECK(found.depth <= kRounding);
  CHECK(found.hardest > 90);
  CHECK(found.touching > 2000);
}

TEST_CASE("admittance: neither a point nor a sphere enters a round mesh", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject3, Renderer::kVirtualProxy3);
  const Deepest found = ball_at_mesh(renderer, 3, 12000);
  CAPTURE(row_of(renderer).name, found.hardest, found.touching, found.depth);
  CHECK(found.depth <= kRounding);
  CHECK(found.touching > 2000);
}

TEST_CASE("admittance: a rigid box never enters a block", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const double friction = GENERATE(0.0, 0.4);
  const Deepest found = box_at_block(renderer, 4, friction, 12000);
  CAPTURE(row_of(renderer).name, friction, found.hardest, found.hardest_turn, found.touching,
          found.depth);
  CHECK(found.depth <= kRounding);
  CHECK(found.touching > 2000);
  CHECK(found.hardest_turn > 0.5);
}

// Contact found no way there: the tool stays where it was last proven free.
TEST_CASE("admittance: a rigid box stays where contact knows no free pose", "[lab]") {
  CHECK(box_at_block(Renderer::kConstrained6, 111, 0, 2500).depth <= kRounding);
  CHECK(box_at_block(Renderer::kConstrained6, 106, 0, 1000).depth <= kRounding);
}

// More facets lie around the sphere than contact can list.
TEST_CASE("admittance: a sphere goes where contact has proven it free", "[lab]") {
  CHECK(ball_at_mesh(Renderer::kVirtualProxy3, 128, 5500).depth <= kRounding);
}

// Contact answers for where a body without friction would be next, past the edge or near it.
TEST_CASE("admittance: a point that friction holds back before an edge does not enter it",
          "[lab]") {
  CHECK(point_at_block(Renderer::kVirtualProxy3, 241, true, 1800).depth <= kRounding);
}

// Many hands, by hand: test_admittance "[many]" takes some minutes.
TEST_CASE("admittance: no hand of two hundred enters a wall", "[.many]") {
  const uint64_t seed = GENERATE(range(uint64_t{100}, uint64_t{300}));
  for (const Renderer renderer : {Renderer::kGodObject3, Renderer::kVirtualProxy3}) {
    for (const bool is_rough : {false, true}) {
      CAPTURE(row_of(renderer).name, seed, is_rough);
      CHECK(point_at_block(renderer, seed, is_rough, 6000).depth <= kRounding);
    }
    CAPTURE(row_of(renderer).name, seed);
    CHECK(ball_at_mesh(renderer, seed, 6000).depth <= kRounding);
  }
  for (const Renderer renderer : {Renderer::kGodObject6, Renderer::kConstrained6}) {
    for (const double friction : {0.0, 0.4}) {
      CAPTURE(row_of(renderer).name, seed, friction);
      CHECK(box_at_block(renderer, seed, friction, 4000).depth <= kRounding);
    }
  }
}
