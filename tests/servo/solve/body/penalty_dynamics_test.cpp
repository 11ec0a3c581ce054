// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/penalty_dynamics.h"

#include "tests/support/near.h"
#include "tests/support/rigid.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kStep = 1e-3;

Coupling spring(double k, double b) {
  return {k, b, 0, 0, 0, 0};
}

/// A body on a spring to the origin, released at 1 m; the largest and the last distance.
struct Swing {
  double largest = 0, last = 0;
};
Swing swing(Integrator integrator, int steps, double b = 0, double mass = 0.1) {
  ToolBody tool = kUnknownTool;
  tool.mass = mass;
  BodyMotion body{{{1, 0, 0}, {}}, {}};
  Swing out;
  for (int i = 0; i < steps; ++i) {
    const BodyWrench f = coupling_wrench(spring(1000, b), tool, {}, body);
    body = penalty_dynamics_step(tool, body, f, {}, integrator, {kStep, 0}).body;
    out.last = norm(body.X_WC.p);
    out.largest = std::max(out.largest, out.last);
  }
  return out;
}

/// Amplitude of an undamped oscillation, from position and velocity.
double amplitude(Integrator integrator, int steps) {
  ToolBody tool = kUnknownTool;
  BodyMotion body{{{1, 0, 0}, {}}, {}};
  for (int i = 0; i < steps; ++i) {
    const BodyWrench f = coupling_wrench(spring(1000, 0), tool, {}, body);
    body = penalty_dynamics_step(tool, body, f, {}, integrator, {kStep, 0}).body;
  }
  const double omega = 100;
  return std::hypot(norm(body.X_WC.p), norm(body.V_WC.v) / omega);
}

double kinetic(const ToolBody& tool, const BodyMotion& body) {
  const Vec3 w_C = rotate(conjugate(body.X_WC.q), body.V_WC.w);
  const Vec3& i = tool.inertia_T;
  return 0.5 * tool.mass * norm_squared(body.V_WC.v) +
         0.5 * (i.x * w_C.x * w_C.x + i.y * w_C.y * w_C.y + i.z * w_C.z * w_C.z);
}

Vec3 angular_momentum(const ToolBody& tool, const BodyMotion& body) {
  const Vec3 w_C = rotate(conjugate(body.X_WC.q), body.V_WC.w);
  const Vec3& i = tool.inertia_T;
  return rotate(body.X_WC.q, {i.x * w_C.x, i.y * w_C.y, i.z * w_C.z});
}

}  // namespace

TEST_CASE("dynamics: growth factors of the three integrators", "[servo][trap]") {
  // k = 1000 N/m, m = 0.1 kg, h = 1 ms, 1000 steps from rest
  CHECK(amplitude(Integrator::kExplicit, 1000) == Approx(144.773).epsilon(1e-5));
  CHECK(amplitude(Integrator::kImplicit, 1000) == Approx(0.006907).epsilon(1e-3));
  CHECK(amplitude(Integrator::kExplicit, 1000) * amplitude(Integrator::kImplicit, 1000) ==
        Approx(1).epsilon(1e-9));
  CHECK(swing(Integrator::kSemiImplicit, static_cast<int>(trials(100000))).largest <=
        1.0013 + 1e-4);
}

TEST_CASE("dynamics: explicit fails where theory says, implicit does not", "[servo][trap]") {
  // m = 0.01 kg, k = 1000 N/m, h = 1 ms need b > h k = 1 N·s/m and b < 2 m/h
  CHECK(swing(Integrator::kExplicit, 2000, 0.1, 0.01).last > 1e3);
  CHECK(swing(Integrator::kExplicit, 2000, 1.1, 0.01).last < 1e-3);
  CHECK(swing(Integrator::kImplicit, 2000, 0.1, 0.01).last < 1e-3);
  // semi-implicit up to ωh = 2: m > k h²/4
  CHECK(swing(Integrator::kSemiImplicit, 2000, 0, 0.9 * 2.5e-4).last > 1e3);
  CHECK(swing(Integrator::kSemiImplicit, 2000, 0, 1.1 * 2.5e-4).largest < 10);
}

TEST_CASE("dynamics: one implicit step is that of the closed form", "[servo]") {
  // u' = (m u + h f)/(m + h² (k + k_T))
  ToolBody tool = kUnknownTool;
  tool.mass = 0.01;
  BodyMotion body{{{0, 0, -1e-3}, {}}, {{0, 0, -0.05}, {}}};
  BodyWrench f = coupling_wrench(spring(1000, 0), tool, {{{0, 0, -5e-3}, {}}, {}}, body);
  const SoftContact floor = spring_contact({}, {}, {0, 0, 1}, 5000);
  const double force = 5000 * 1e-3 - 1000 * 4e-3;
  // h K u belongs to the right side: the spring force at the end of the step
  const double expected = (0.01 * -0.05 + kStep * force) / (0.01 + kStep * kStep * 6000);
  const auto next =
      penalty_dynamics_step(tool, body, f, {&floor, 1}, Integrator::kImplicit, {kStep, 0});
  CHECK(next.body.V_WC.v.z == Approx(expected).epsilon(1e-12));
}

TEST_CASE("dynamics: the torque-free body keeps its angular momentum", "[servo][trap]") {
  ToolBody tool = kUnknownTool;
  tool.mass = 1;
  tool.inertia_T = {1, 2, 3};
  const BodyMotion start{{}, {{}, {0.1, 1.0, 0.1}}};
  for (const Integrator integrator : {Integrator::kSemiImplicit, Integrator::kImplicit}) {
    BodyMotion body = start;
    double energy = kinetic(tool, body);
    for (int i = 0; i < 10000; ++i) {
      body = penalty_dynamics_step(tool, body, {}, {}, integrator, {kStep, 0}).body;
      if (integrator == Integrator::kImplicit) REQUIRE(kinetic(tool, body) <= energy * (1 + 1e-9));
      energy = kinetic(tool, body);
    }
    CAPTURE(static_cast<int>(integrator));
    CHECK(norm(angular_momentum(tool, body)) ==
          Approx(norm(angular_momentum(tool, start)))
              .epsilon(integrator == Integrator::kImplicit ? 1e-2 : 1e-3));
  }
}

TEST_CASE("dynamics: implicit energy never grows without input", "[servo][trap]") {
  // m from 1e-4 to 10 kg, k up to 1e6 N/m: a body thrown onto a floor, held by a coupling at rest
  const double mass = GENERATE(1e-4, 1e-2, 1.0, 10.0);
  const double k = GENERATE(1e3, 1e5, 1e6);
  ToolBody tool = kUnknownTool;
  tool.mass = mass;
  tool.inertia_T = mass * 1e-3 * Vec3{1, 1, 1};
  const Coupling coupling{1000, 0, 1, 0, 0, 0};
  BodyMotion body{{{0, 0, 2e-3}, {}}, {{0, 0, -0.5}, {}}};
  const ToolMotion hand{{{0, 0, -1e-3}, {}}, {}};
  double before = std::numeric_limits<double>::infinity();
  std::vector<SoftContact> feet;
  for (const double x : {-0.02, 0.02}) {
    for (const double y : {-0.02, 0.02})
      feet.push_back(spring_contact({x, y, 0}, {}, {0, 0, 1}, k));
  }
  for (int i = 0; i < 2000; ++i) {
    const BodyWrench f = coupling_wrench(coupling, tool, hand, body);
    const double energy = f.energy + soft_contact_wrench(feet, body).energy + kinetic(tool, body);
    CAPTURE(i, mass, k);
    REQUIRE(energy <= before * (1 + 1e-9) + 1e-15);
    before = energy;
    const auto next = penalty_dynamics_step(tool, body, f, feet, Integrator::kImplicit, {kStep, 0});
    REQUIRE(next.is_solved);
    body = next.body;
  }
  // and it ends at rest, where the springs balance
  CHECK(before < 0.5 * mass * 0.25 + 1e-3);
}

TEST_CASE("dynamics: Jacobians of contacts and coupling against central differences",
          "[servo][trap]") {
  Random random(11);
  for (size_t i = 0; i < trials(200); ++i) {
    ToolBody tool = kUnknownTool;
    tool.centre_T = 0.03 * random.direction();
    const BodyMotion body{random.pose(0.1), random_twist(random, 0.2, 2)};
    SoftContact contact = random_contact(random, body.X_WC);
    const auto touch = [&](const BodyMotion& at) {
      BodyWrench sum;
      add_soft_contact(contact, at, sum);
      return sum;
    };
    if (norm(touch(body).F_W.f) > 0) CHECK(jacobian_error(touch, body, 1e-7, 1e-4) <= 1e-5);
    // a surface that bends, beside the point of the contact, as far as it bends and beyond
    contact.curvature = random.uniform(5, 200);
    const Vec3 beside = cross(contact.normal_W, random.direction());
    contact.point_W += (i % 2 == 0 ? 2e-3 : 2e-2) * beside;
    const double fall = -gap_of(contact, body.X_WC);
    contact.point_W += (1e-3 - std::min(fall, 0.0)) * contact.normal_W;
    REQUIRE(norm(touch(body).F_W.f) > 0);
    CHECK(jacobian_error(touch, body, 1e-7, 1e-4) <= 1e-5);
    const ToolMotion hand{random.pose(0.12), random_twist(random, 0.2, 2)};
    const Coupling coupling{1000, 0.5, 2, 1e-3, i % 2 == 0 ? 5.0 : 0, i % 3 == 0 ? 0.5 : 0};
    const auto hold = [&](const BodyMotion& at) {
      return coupling_wrench(coupling, tool, hand, at);
    };
    CHECK(jacobian_error(hold, body, 1e-6, 1e-4) <= 1e-5);
  }
}

TEST_CASE("dynamics: a curved contact pushes as the ball it stands for", "[servo]") {
  // a point beside the top of a ball: distance √((R − d)² + s²) − R, to second order
  const double radius = 0.05;
  SoftContact contact = spring_contact({}, {0, 0, radius}, {0, 0, 1}, 1000);
  contact.curvature = 1 / radius;
  for (const double beside : {0.0, 1e-3, 2e-3, 4e-3}) {
    for (const double depth : {0.0, 2e-4, 5e-4}) {
      const Vec3 p{beside, 0, radius - depth};
      const double gap = gap_of(contact, {p, {}});
      CAPTURE(beside, depth);
      CHECK(gap == Approx(norm(p) - radius).margin(0.02 * depth + 1e-6));
      if (!(gap < -1e-5)) continue;
      const BodyWrench sum = soft_contact_wrench({&contact, 1}, {{p, {}}, {}});
      // along the way out of the ball
      CHECK(norm(cross(normalized(sum.F_W.f), normalized(p))) < 2e-3);
    }
  }
}

TEST_CASE("dynamics: stable from 10 g to 1 kg at every coupling a device allows, explicit fails",
          "[servo][trap]") {
  // pressed into a floor as stiff as ten contacts, by couplings of up to 5000 N/m
  const double mass = GENERATE(0.01, 0.1, 1.0);
  const double k = GENERATE(200.0, 1000.0, 5000.0);
  const auto rest_error = [&](Integrator integrator) {
    ToolBody tool = kUnknownTool;
    tool.mass = mass;
    tool.inertia_T = mass * 1e-3 * Vec3{1, 1, 1};
    const Coupling coupling{k, 0.02 * std::sqrt(k * mass), k * 1e-3, 1e-3, 0, 0};
    const ToolMotion hand{{{0, 0, -2e-3}, {}}, {}};
    std::vector<SoftContact> feet;
    for (const double x : {-0.02, 0.02}) {
      for (const double y : {-0.02, 0.02}) {
        feet.push_back(spring_contact({x, y, 0}, {x, y, 0}, {0, 0, 1}, 2500));
      }
    }
    BodyMotion body{{{0, 0, 1e-3}, {}}, {{0, 0, -0.1}, {}}};
    double most = 0;
    for (int i = 0; i < 6000; ++i) {
      const BodyWrench f = coupling_wrench(coupling, tool, hand, body);
      body = penalty_dynamics_step(tool, body, f, feet, integrator, {kStep, 0}).body;
      if (!(norm(body.X_WC.p) < 1)) return std::numeric_limits<double>::infinity();
      // closed form: the springs in series
      const double at_rest = -k * 2e-3 / (k + 1e4);
      if (i >= 5000) most = std::max(most, std::fabs(body.X_WC.p.z - at_rest));
    }
    return most;
  };
  CAPTURE(mass, k);
  CHECK(rest_error(Integrator::kImplicit) < 1e-6);
  // undamped modes grow by √(1 + ω² h²) a step; damping b > h k would be needed
  CHECK(rest_error(Integrator::kExplicit) > 1e-4);
}

TEST_CASE("dynamics: a contact pushes out and never pulls", "[servo][trap]") {
  // the force must push the tool out, in every pose and at every speed
  Random random(12);
  for (size_t i = 0; i < trials(20000); ++i) {
    const BodyMotion body{random.pose(0.1), random_twist(random, 2, 20)};
    SoftContact c = random_contact(random, body.X_WC);
    c.damping = 5;
    BodyWrench sum;
    const double push = add_soft_contact(c, body, sum);
    REQUIRE(push >= 0);
    REQUIRE(dot(sum.F_W.f, c.normal_W) >= 0);
    c.point_W = body.X_WC * c.tool_point_C - 1e-6 * c.normal_W;
    BodyWrench apart;
    REQUIRE(add_soft_contact(c, body, apart) == 0);
    REQUIRE(apart.F_W == Wrench{});
  }
}

TEST_CASE("dynamics: no point travels further than allowed", "[servo]") {
  ToolBody tool = kUnknownTool;
  BodyMotion body{{}, {{3, 0, 0}, {0, 40, 0}}};
  const auto next = penalty_dynamics_step(tool, body, {}, {}, Integrator::kImplicit, {kStep, 1e-3});
  CHECK(next.was_cut);
  const Vec3 far = tool.radius * Vec3{0, 0, 1};
  CHECK(norm(next.body.X_WC * far - far) <= 1e-3 * (1 + 1e-9));
  CHECK(norm(next.body.V_WC.v) + tool.radius * norm(next.body.V_WC.w) == Approx(1.0));
}

TEST_CASE("dynamics: what is not finite leaves the body where it is", "[servo]") {
  ToolBody tool = kUnknownTool;
  const BodyMotion body{{{1, 2, 3}, {}}, {{1, 0, 0}, {}}};
  BodyWrench f;
  f.F_W.f.x = std::nan("");
  for (const Integrator integrator : {Integrator::kExplicit, Integrator::kImplicit}) {
    const auto next = penalty_dynamics_step(tool, body, f, {}, integrator, {kStep, 0});
    CHECK_FALSE(next.is_solved);
    CHECK(next.body.X_WC == body.X_WC);
    CHECK(next.body.V_WC == Twist{});
  }
}
