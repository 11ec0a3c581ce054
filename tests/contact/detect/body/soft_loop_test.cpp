// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/soft_loop.h"

#include <functional>

#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<std::array<Vec3, 3>> triangles_of(const TriangleMesh& mesh, const Pose& X_WM) {
  std::vector<std::array<Vec3, 3>> out;
  for (const Triangle& t : mesh.triangles) {
    out.push_back(
        {X_WM * mesh.vertices[t[0]], X_WM * mesh.vertices[t[1]], X_WM * mesh.vertices[t[2]]});
  }
  return out;
}

/// Those within a radius of a point.
std::vector<std::array<Vec3, 3>> triangles_near(const std::vector<std::array<Vec3, 3>>& all,
                                                const Vec3& centre, double radius) {
  std::vector<std::array<Vec3, 3>> out;
  for (const auto& t : all) {
    const Vec3 lower = component_min(component_min(t[0], t[1]), t[2]);
    const Vec3 upper = component_max(component_max(t[0], t[1]), t[2]);
    const Vec3 nearest = component_max(lower, component_min(upper, centre));
    if (norm(nearest - centre) <= radius) out.push_back(t);
  }
  return out;
}

/// The hand's pose at time t.
using Path = std::function<Pose(double t)>;

ToolMotion motion_at(const Path& path, double t) {
  const double h = 1e-6;
  const Pose before = path(t - h), after = path(t + h);
  return {path(t),
          {(1 / (2 * h)) * (after.p - before.p),
           (1 / (2 * h)) * to_rotation_vector(after.q * conjugate(before.q))}};
}

/// Penetration of the meshes by a hand that presses as hard as the coupling allows.
struct Pressing {
  size_t pairs = 0;    // intersecting triangles, in total
  double nearest = 1;  // smallest distance of a tool point to the obstacle, by the field [m]
  int pressed = 0, clamped = 0, ticks = 0;
};

Pressing press(const SoftPair& pair, SoftLoop& loop, const Path& path, double duration) {
  Pressing out;
  const auto obstacle = triangles_of(pair.object.mesh.view(), {});
  const double most = loop.in_force.coupling.max_force;
  const auto n = static_cast<int>(duration / kTick);
  for (int i = 0; i < n; ++i) {
    const auto solution = loop.tick(motion_at(path, kTick * i));
    REQUIRE(solution.finite);
    const Pose& X_WP = solution.proxy.X_WT;
    const double force = norm(solution.F_hand_W.f);
    out.pressed += solution.n_pushing > 0;
    out.clamped += force > 0.99 * most;
    ++out.ticks;
    if (i % 20 != 0) continue;
    for (size_t k = 0; k < pair.shell.x.size(); ++k) {
      const Vec3 p =
          X_WP * Vec3{static_cast<double>(pair.shell.x[k]), static_cast<double>(pair.shell.y[k]),
                      static_cast<double>(pair.shell.z[k])};
      out.nearest = std::min(out.nearest, sample_field(pair.field.view(), p).distance);
    }
    const auto near = triangles_near(obstacle, X_WP.p, pair.shell.radius);
    out.pairs += cgal_triangle_pairs(near, triangles_of(pair.tool.mesh.view(), X_WP)).size();
  }
  return out;
}

/// Two voxels of force layer; one point at half its depth carries all the force of the coupling,
/// and all its torque at the tool's radius; no point moves further in a tick than the look-ahead.
void prescribe(SoftLoop& loop, const SoftPair& pair, SoftSolver solver) {
  const double stiffness = 2000, layer = 2 * pair.size;
  loop.voxel.force = {stiffness, 10, layer};
  loop.voxel.clusters = {3 * pair.size, 0.5};
  loop.model.solver = solver;
  loop.in_force.tool.mass = 0.05;
  loop.in_force.tool.inertia_T = 2e-5 * Vec3{1, 1, 1};
  const double half = 0.5 * stiffness * layer;
  loop.in_force.coupling = {800, 1, 0.5, 1e-3, half, half * pair.shell.radius};
  loop.model.contact_damping = 2;
  loop.model.max_travel = pair.size;
}

/// Nothing intersects although the layer was compressed, mostly at the coupling's limit.
void check_apart(const SoftPair& pair, Asked asked, SoftSolver solver, const Path& path) {
  SoftLoop loop(pair, asked);
  prescribe(loop, pair, solver);
  const Pressing out = press(pair, loop, path, kSlowdown > 1 ? 0.1 : 1);
  CAPTURE(static_cast<int>(asked), static_cast<int>(solver));
  CHECK(out.pairs == 0);
  CHECK(3 * out.pressed > 2 * out.ticks);
  if (kSlowdown == 1) CHECK(2 * out.clamped > out.ticks);
  if (asked == Asked::kField) CHECK(out.nearest < 0.9 * loop.voxel.force.offset);
}

}  // namespace

TEST_CASE("soft loop: no tool triangle through the obstacle's, pressed as hard as the coupling can",
          "[contact][trap]") {
  const auto asked = GENERATE(Asked::kField, Asked::kTangentPlanes);
  const auto solver = GENERATE(SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics);
  SECTION("a bumpy ball on a box and over its edges") {
    static const SoftPair pair(make_box({0.06, 0.05, 0.03}), make_bumpy_ball(0.012, 3), 1e-3);
    check_apart(pair, asked, solver, [](double t) {
      const double high = 0.03 - std::min(0.2 * t, 0.02);
      return Pose{{0.035 * std::sin(6 * t), 0.028 * std::sin(4.3 * t), high},
                  from_rotation_vector({1.5 * std::sin(5 * t), 2 * t, 0.5 * t})};
    });
  }
  SECTION("a peg in a wide hole, tilted and turned against its wall") {
    static const SoftPair pair(make_hole({{0.03, 0.03, {48, 6}}, 0, 0.05}),
                               make_peg({0.02, 0.04, {48, 8}}), 1e-3);
    check_apart(pair, asked, solver, [](double t) {
      return Pose{{0.02 * std::sin(5 * t), 0.02 * std::sin(7 * t), 0.01 * std::sin(3 * t)},
                  from_rotation_vector({0.6 * std::sin(4 * t), 0.6 * std::sin(6 * t), t})};
    });
  }
}

TEST_CASE("soft loop: no tool triangle through the bunny's", "[contact][trap]") {
  const Soup soup = load_off("bunny00.off", 0.1);
  if (soup.triangles.empty() || kSlowdown > 1) return;
  const SoftPair pair(soup, make_bumpy_ball(0.018, 3), 2e-3);
  for (const SoftSolver solver : {SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics}) {
    check_apart(pair, Asked::kField, solver, [](double t) {
      const double high = 0.065 - 0.065 * std::min(10 * t, 1.0);
      return Pose{{0.03 * std::sin(7 * t), 0.03 * std::sin(5 * t), high + 0.02 * std::sin(4 * t)},
                  from_rotation_vector({1.5 * std::sin(5 * t), 2 * t, 0.5 * t})};
    });
  }
}

TEST_CASE("soft loop: without the force layer the same hand presses triangles through triangles",
          "[contact]") {
  const SoftPair pair(make_box({0.06, 0.05, 0.03}), make_bumpy_ball(0.012, 3), 1e-3);
  SoftLoop loop(pair, Asked::kField);
  prescribe(loop, pair, SoftSolver::kQuasiStatic);
  loop.voxel.force.offset = 0;
  const auto path = [](double t) { return Pose{{0, 0, 0.03 - std::min(0.2 * t, 0.02)}, {}}; };
  CHECK(press(pair, loop, path, 0.2).pairs > 0);
}

TEST_CASE("soft loop: a hand that jumps through a plate leaves the proxy on its side",
          "[contact][trap]") {
  // the speed limit: no point moves further in a tick than the detector looks ahead
  const auto solver = GENERATE(SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics);
  const SoftPair pair(make_box({0.06, 0.06, 0.003}), make_bumpy_ball(0.008, 2), 1e-3);
  const auto path = [](double t) {
    return Pose{{0, 0, t < 5e-3 ? 0.03 : -0.03}, from_rotation_vector({t, 0, 0})};
  };
  SoftLoop loop(pair, Asked::kField);
  prescribe(loop, pair, solver);
  CHECK(press(pair, loop, path, 0.1).pairs == 0);
  CHECK(loop.state.proxy.X_WT.p.z > 0.008);
  SoftLoop unlimited(pair, Asked::kField);
  prescribe(unlimited, pair, solver);
  unlimited.model.max_travel = 0;
  press(pair, unlimited, path, 0.1);
  if (solver == SoftSolver::kQuasiStatic) CHECK(unlimited.state.proxy.X_WT.p.z < -0.008);
}

TEST_CASE("soft loop: retreat at 0.5 m/s with contact at 100 Hz is never attractive",
          "[contact][trap]") {
  // a box pressed flat and tilted onto a plate, then withdrawn, straight and at an angle: contacts
  // must never pull the hand further in than it would be without them
  const auto asked = GENERATE(Asked::kField, Asked::kTangentPlanes, Asked::kExact);
  const auto solver =
      GENERATE(SoftSolver::kDirect, SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics);
  static const SoftPair pair(make_box({0.08, 0.08, 0.02}), make_box({0.02, 0.015, 0.01}), 1e-3);
  for (const Vec3& away : {Vec3{0, 0, 1}, Vec3{0.6, 0, 0.8}, Vec3{0, -0.8, 0.6}}) {
    for (const double tilt : {0.0, 0.05, -0.2}) {
      for (int late = 0; late<10; late += kSlowdown> 1 ? 9 : 3) {
        SoftLoop loop(pair, asked);
        prescribe(loop, pair, solver);
        loop.model.max_travel = 4 * pair.size;
        // the tool's height is 5 mm, more where it is tilted
        const double layer = asked == Asked::kExact ? 0 : 2e-3;
        const double rest = 0.015 + layer + 0.01 * std::fabs(tilt);
        const auto path = [&](double t) {
          const double press = 1.5e-3 * std::min(t / 0.05, 1.0);
          const double leave = std::max(t - 0.1 - 1e-3 * late, 0.0);
          return Pose{Vec3{0, 0, rest + 0.2e-3 - press} + 0.5 * leave * away,
                      from_rotation_vector({tilt, 0, 0.1 + 4 * leave})};
        };
        double pushed = 0;
        for (int i = 0; i < 150; ++i) {
          const ToolMotion hand = motion_at(path, kTick * i);
          if (i >= 50) loop.every = 10;
          const ContactSet none{};
          SoftProxyState alone = loop.state;
          const BodySolution with = loop.tick(hand);
          const BodySolution without = solve_soft_proxy(
              loop.model, alone,
              {{}, hand, &none, kTick, loop.in_force.tool, loop.in_force.coupling});
          CAPTURE(static_cast<int>(asked), static_cast<int>(solver), i, late, tilt, away);
          CAPTURE(with.F_hand_W.f.z, without.F_hand_W.f.z, hand.X_WT.p.z);
          REQUIRE(with.F_hand_W.f.z >= without.F_hand_W.f.z - 1e-9);
          pushed = std::max(pushed, with.F_hand_W.f.z);
          if (solver != SoftSolver::kPenaltyDynamics) REQUIRE(with.F_hand_W.f.z >= -1e-9);
          // 13 ms later a set from the way out is in use, and no contact is left
          if (i > 125 && solver != SoftSolver::kPenaltyDynamics) REQUIRE(with.F_hand_W == Wrench{});
        }
        CHECK(pushed > 0.2);
      }
    }
  }
}

TEST_CASE("soft loop: nothing is felt past an edge, though the contacts are old",
          "[contact][trap]") {
  // planes that stay behind would be ghost walls
  static const SoftPair pair(make_box({0.04, 0.08, 0.02}), make_icosphere(0.006, 3), 1e-3);
  const auto path = [](double t) {
    return Pose{{0.5 * std::max(t - 0.02, 0.0), 0, 0.0175 - std::min(0.05 * t, 1e-3)}, {}};
  };
  for (int late = 0; late<10; late += kSlowdown> 1 ? 3 : 1) {
    SoftLoop fresh(pair, Asked::kField), stale(pair, Asked::kField);
    for (SoftLoop* loop : {&fresh, &stale}) prescribe(*loop, pair, SoftSolver::kDirect);
    // the tenth tick after the first `late` ones
    for (int i = 0; i < late; ++i) stale.tick(motion_at(path, 0));
    stale.every = 10;
    double left = 1, ghost = 0, felt = 0;
    for (int i = 0; i < 100; ++i) {
      const ToolMotion hand = motion_at(path, kTick * i);
      const double now = fresh.tick(hand).F_hand_W.f.z, old = stale.tick(hand).F_hand_W.f.z;
      felt = std::max(felt, old);
      if (now == 0 && felt > 0) left = std::min(left, hand.X_WT.p.x);
      if (hand.X_WT.p.x > left + 1e-3) ghost = std::max(ghost, std::fabs(old));
    }
    CAPTURE(late, left);
    CHECK(felt > 0.5);
    CHECK(left < 0.03);
    CHECK(ghost == 0);
  }
}
