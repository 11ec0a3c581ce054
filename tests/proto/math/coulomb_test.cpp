// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math/coulomb.cpp.
#include "proto/math/coulomb.h"

#include <limits>

#include "proto/math/units.h"
#include "tests/support/contact_rows.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kDirection = 1e-4;  // of friction at slow slip, see CoulombSolver [rad]
constexpr double kG = 9.81, kH = 1e-3;

/// A box of 1 kg and 0.1 × 0.1 × 0.04 m on its face.
const Mat6 kBox = mass_matrix(1, {{{9.667e-4, 0, 0}, {0, 9.667e-4, 0}, {0, 0, 1.667e-3}}});

std::vector<FrictionContact> rubbing_corners(double friction) {
  std::vector<FrictionContact> contacts;
  for (const double x : {-0.05, 0.05}) {
    for (const double y : {-0.05, 0.05}) {
      contacts.push_back({{x, y, -0.02}, {0, 0, 1}, 0, friction, {}});
    }
  }
  return contacts;
}

double kinetic_energy(const Mat6& M, const Twist& v) {
  return 0.5 * dot(M * v, v);
}

/// Residual of Coulomb's law at one contact: λ − projection onto the cone of λ − (u + μ |u_t| n),
/// velocity in units of impulse by `mass`. Zero exactly if the law holds.
Vec3 law_residual(const FrictionContact& c, const Twist& v, const Vec3& impulse, double mass) {
  const Vec3 u = velocity_at(v, c.r);
  const double u_n = dot(u, c.normal);
  const Vec3 u_t = u - u_n * c.normal;
  const Vec3 modified = u_t + (u_n - c.least_speed + c.friction * norm(u_t)) * c.normal;
  const Vec3 x = impulse - mass * modified;
  const double x_n = dot(x, c.normal);
  const Vec3 x_t = x - x_n * c.normal;
  const double t = norm(x_t), mu = c.friction;
  Vec3 projected = x;
  if (mu * t <= -x_n) {
    projected = {};
  } else if (t > mu * x_n) {
    const double along = (x_n + mu * t) / (1 + mu * mu);
    projected = along * c.normal + mu * along / t * x_t;
  }
  return impulse - projected;
}

double worst_residual(std::span<const FrictionContact> contacts, const FrictionStep& out,
                      double mass) {
  double worst = 0;
  for (size_t i = 0; i < contacts.size(); ++i) {
    worst = std::max(worst, norm(law_residual(contacts[i], out.v, out.impulses[i], mass)));
  }
  return worst;
}

/// Oracle: block Gauss–Seidel with an exact round cone at each contact, its own 3×3 problem by
/// projected iteration. False if it does not converge.
bool by_gauss_seidel(const MotionMetric& metric, const Twist& v_free,
                     std::span<const FrictionContact> contacts, Twist& v,
                     std::vector<Vec3>& impulse) {
  impulse.assign(contacts.size(), {});
  v = v_free;
  for (int sweep = 0; sweep < 3000; ++sweep) {
    double changed = 0;
    for (size_t i = 0; i < contacts.size(); ++i) {
      const FrictionContact& c = contacts[i];
      // at least the largest response of the contact's velocity to a unit impulse
      double response_bound = 0;
      for (int k = 0; k < 3; ++k) {
        Vec3 unit;
        unit[k] = 1;
        const Twist dv = response(metric, {unit, cross(c.r, unit)});
        response_bound += dot(velocity_at(dv, c.r), unit);
      }
      for (int inner = 0; inner < 60; ++inner) {
        const Vec3 step = -law_residual(c, v, impulse[i], 1 / response_bound);
        impulse[i] += step;
        v = v + response(metric, {step, cross(c.r, step)});
        changed = std::max(changed, norm(step) * response_bound);
        if (norm(step) * response_bound < 1e-14) break;
      }
    }
    if (changed < 1e-12) return true;
  }
  return false;
}

/// Contacts of a body of radius 1 on a plane, in a bowl, all round, or around a peg.
std::vector<FrictionContact> random_contacts(Random& random, size_t n, double most_friction) {
  std::vector<FrictionContact> contacts;
  const Vec3 axis = random.direction();
  const size_t arrangement = random.index(4);
  const double friction = random.uniform(0, most_friction);
  for (size_t i = 0; i < n; ++i) {
    Vec3 normal = random.direction(), r = random.uniform(0, 1) * random.direction();
    if (arrangement == 0) normal = axis, r = r - (dot(r, axis) + 0.3) * axis;
    if (arrangement == 1) normal = normalized(axis + 0.7 * normal);
    if (arrangement == 2) normal = normalized(cross(axis, normal));
    const double gap_speed = random.index(2) == 0 ? 0 : random.uniform(0, 0.3);
    contacts.push_back({r, normal, -gap_speed, friction, {}});
  }
  return contacts;
}

}  // namespace

TEST_CASE("coulomb: free space is exactly free", "[math][trap]") {
  CoulombSolver solver(4);
  const Twist v{{0.1, 0.2, 1.0 / 3}, {1, 2, 3}};
  std::vector<FrictionContact> contacts = rubbing_corners(0.5);
  for (FrictionContact& c : contacts) c.least_speed = -100;
  const FrictionStep out = solver.step(factor_metric(kBox), v, contacts);
  CHECK(out.converged);
  CHECK(out.v == v);
  CHECK(out.impulse == Wrench{});
}

TEST_CASE("coulomb: a box on an incline sticks or slips", "[math]") {
  const double mu = GENERATE(0.1, 0.4, 0.8, 1.5);
  const double degrees = GENERATE(-0.5, 0.5);
  const double angle = std::atan(mu) + degrees * kDegree;
  CoulombSolver solver(4);
  const MotionMetric metric = factor_metric(kBox);
  const Vec3 gravity{kG * std::sin(angle), 0, -kG * std::cos(angle)};
  Twist v;
  CAPTURE(mu, degrees);
  for (int tick = 1; tick <= 100; ++tick) {
    const FrictionStep out = solver.step(metric, {v.v + kH * gravity, v.w}, rubbing_corners(mu));
    REQUIRE(out.converged);
    v = out.v;
    const double expected =
        degrees < 0 ? 0 : kG * (std::sin(angle) - mu * std::cos(angle)) * kH * tick;
    REQUIRE_THAT(v.v, IsNear({expected, 0, 0}, 1e-9));
    REQUIRE_THAT(v.w, IsNear({}, 1e-8));
    REQUIRE(out.impulse.f.z == Approx(kG * std::cos(angle) * kH).epsilon(1e-7));
  }
}

TEST_CASE("coulomb: a sliding body slows down by mu g and stops", "[math][trap]") {
  CoulombSolver solver(4);
  const MotionMetric metric = factor_metric(kBox);
  const double mu = 0.3, speed = 0.05;
  const Vec3 ahead = normalized(Vec3{3, 4, 0});
  Twist v{speed * ahead, {}};
  for (int tick = 1; tick <= 40; ++tick) {
    const FrictionStep out =
        solver.step(metric, {v.v + Vec3{0, 0, -kG * kH}, v.w}, rubbing_corners(mu));
    REQUIRE(out.converged);
    v = out.v;
    const double expected = std::max(0.0, speed - mu * kG * kH * tick);
    CAPTURE(tick);
    REQUIRE_THAT(v.v, IsNear(expected * ahead, 1e-8));
  }
  CHECK(norm(v.v) <= 1e-12);
}

TEST_CASE("coulomb: a belt takes a box along, up to its own speed", "[math]") {
  CoulombSolver solver(4);
  const double mu = 0.3;
  const Vec3 belt{0.03, -0.04, 0};
  std::vector<FrictionContact> contacts = rubbing_corners(mu);
  for (FrictionContact& c : contacts) c.obstacle_velocity = belt;
  Twist v;
  for (int tick = 1; tick <= 30; ++tick) {
    v = solver.step(factor_metric(kBox), {v.v + Vec3{0, 0, -kG * kH}, v.w}, contacts).v;
    const double speed = std::min(norm(belt), mu * kG * kH * tick);
    CAPTURE(tick);
    REQUIRE_THAT(v.v, IsNear(speed / norm(belt) * belt, 1e-8));
  }
}

TEST_CASE("coulomb: a sliding body is not lifted off", "[math][trap]") {
  // the convex law alone would give u_n = μ |u_t|
  CoulombSolver solver(4);
  const double mu = GENERATE(0.2, 1.0, 2.0);
  const FrictionStep out =
      solver.step(factor_metric(kBox), {{5, 0, -kG * kH}, {}}, rubbing_corners(mu));
  CHECK(out.converged);
  CHECK(std::fabs(out.v.v.z) <= 1e-8);
  CHECK(norm(out.v.w) <= 1.0);
}

TEST_CASE("coulomb: a spinning disc is braked at its rim", "[math]") {
  // thirty-two contacts at radius R: torque μ m g R, no net force
  constexpr double kR = 0.03, kMu = 0.25, kInertia = 4.5e-4;
  const Mat6 M = mass_matrix(1, {{{2.5e-4, 0, 0}, {0, 2.5e-4, 0}, {0, 0, kInertia}}});
  std::vector<FrictionContact> rim;
  for (int i = 0; i < 32; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / 32;
    rim.push_back({{kR * std::cos(angle), kR * std::sin(angle), 0}, {0, 0, 1}, 0, kMu, {}});
  }
  CoulombSolver solver(32);
  const FrictionStep out = solver.step(factor_metric(M), {{0, 0, -kG * kH}, {0, 0, 20}}, rim);
  REQUIRE(out.converged);
  CHECK_THAT(out.v.w, IsNear({0, 0, 20 - kMu * kG * kH * kR / kInertia}, 1e-7));
  CHECK_THAT(out.v.v, IsNear({}, 1e-8));
  // rotating slowly it stops and does not turn back
  const FrictionStep slow = solver.step(factor_metric(M), {{0, 0, -kG * kH}, {0, 0, 0.1}}, rim);
  CHECK_THAT(slow.v.w, IsNear({}, 1e-9));
}

TEST_CASE("coulomb: the law holds at random contacts", "[math][property]") {
  Random random(41);
  CoulombSolver solver(64);
  size_t converged = 0;
  const auto n = sweep(4000);
  for (size_t trial = 0; trial < n; ++trial) {
    const Mat6 M = random_metric(random, 1);
    const Twist v_free{random.direction(), random.uniform(0, 1) * random.direction()};
    const size_t most = random.index(4) == 0 ? 64 : 8;
    const auto contacts = random_contacts(random, 1 + random.index(most), 0.8);
    const MotionMetric metric = factor_metric(M);
    const FrictionStep out = solver.step(metric, v_free, contacts);
    CAPTURE(trial, contacts.size(), out.iterations, out.solves);
    // energy, whether it converged or not
    REQUIRE(kinetic_energy(M, out.v) <= kinetic_energy(M, v_free) * (1 + 1e-9));
    Wrench total;
    double pushes = 0;
    for (size_t i = 0; i < contacts.size(); ++i) {
      const FrictionContact& c = contacts[i];
      total = total + Wrench{out.impulses[i], cross(c.r, out.impulses[i])};
      const double along = dot(out.impulses[i], c.normal);
      pushes += along;
      REQUIRE(norm(out.impulses[i] - along * c.normal) <=
              c.friction * along + tol(1e-9) * (1 + along));
      REQUIRE(dot(velocity_at(out.v, c.r), c.normal) >= c.least_speed - tol(1e-7));
    }
    REQUIRE(norm(total.f - out.impulse.f) <= tol(1e-9) * (1 + norm(out.impulse.f)));
    REQUIRE(norm(total.t - out.impulse.t) <= tol(1e-9) * (1 + norm(out.impulse.f)));
    const Wrench change = M * (out.v - v_free);
    REQUIRE(norm(change.f - total.f) <= tol(1e-7));
    if (!out.converged) continue;
    ++converged;
    REQUIRE(worst_residual(contacts, out, 1) <= tol(kDirection) * (1 + pushes));
  }
  // failures are flagged and answered by the convex law
  CHECK(100 * (n - converged) <= n);
}

TEST_CASE("coulomb: agrees with a block Gauss-Seidel of round cones", "[math][property]") {
  Random random(43);
  CoulombSolver solver(8);
  size_t compared = 0, differ = 0;
  for (size_t trial = 0; trial < trials(1500); ++trial) {
    const Mat6 M = random_metric(random, 1);
    const Twist v_free{random.direction(), random.uniform(0, 1) * random.direction()};
    const auto contacts = random_contacts(random, 1 + random.index(4), 0.5);
    const MotionMetric metric = factor_metric(M);
    const FrictionStep out = solver.step(metric, v_free, contacts);
    Twist v;
    std::vector<Vec3> impulse;
    if (!out.converged || !by_gauss_seidel(metric, v_free, contacts, v, impulse)) continue;
    ++compared;
    CAPTURE(trial, contacts.size());
    REQUIRE(worst_residual(contacts, out, 1) <= tol(kDirection) * 2);
    // if a body jams between contacts the law has several solutions
    double residual = 0;
    for (size_t i = 0; i < contacts.size(); ++i) {
      residual = std::max(residual, norm(law_residual(contacts[i], v, impulse[i], 1)));
    }
    REQUIRE(residual <= tol(1e-9));
    differ += norm(out.v.v - v.v) > tol(1e-5) || norm(out.v.w - v.w) > tol(2e-5);
  }
  CHECK(200 * differ <= compared);
  CHECK(2 * compared > trials(1500));
}

TEST_CASE("coulomb: without friction it is least constraint", "[math][property]") {
  Random random(47);
  CoulombSolver solver(64);
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const MotionMetric metric = factor_metric(random_metric(random, 1));
    const Twist v_free{random.direction(), random.direction()};
    const auto contacts = random_contacts(random, 1 + random.index(64), 0);
    std::vector<MotionRow> rows;
    for (const auto& c : contacts) {
      rows.push_back({{c.normal, cross(c.r, c.normal)}, c.least_speed});
    }
    const FrictionStep out = solver.step(metric, v_free, contacts);
    const ConstrainedMotion qp = least_constraint(metric, v_free, rows);
    CAPTURE(trial, contacts.size());
    REQUIRE(out.converged);
    REQUIRE_THAT(out.v.v, IsNear(qp.a.v, 1e-8));
    REQUIRE_THAT(out.v.w, IsNear(qp.a.w, 1e-8));
  }
}

TEST_CASE("coulomb: what is not finite or too much is flagged", "[math][trap]") {
  CoulombSolver solver(4);
  const MotionMetric metric = factor_metric(kBox);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int what = 0; what < 6; ++what) {
      Twist v_free{{0, 0, -1}, {}};
      std::vector<FrictionContact> contacts = rubbing_corners(0.5);
      if (what == 0) v_free.v.x = bad;
      if (what == 1) contacts[1].r.x = bad;
      if (what == 2) contacts[1].normal.x = bad;
      if (what == 3) contacts[1].least_speed = -bad;
      if (what == 4) contacts[1].friction = bad;
      if (what == 5) contacts[1].obstacle_velocity.z = bad;
      const FrictionStep out = solver.step(metric, v_free, contacts);
      CHECK_FALSE(out.converged);
      CHECK(is_finite(out.v));
    }
  }
  const std::vector<FrictionContact> many(5, {{}, {0, 0, 1}, 0, 0.5, {}});
  CHECK_FALSE(solver.step(metric, {{0, 0, -1}, {}}, many).converged);
  CHECK_FALSE(solver.step({}, {{0, 0, -1}, {}}, rubbing_corners(0.5)).converged);
}

TEST_CASE("coulomb: held between a floor and a plate that goes by, a body stays or goes along",
          "[math][trap]") {
  // no room to separate: a law without the shift contradicts itself
  CoulombSolver solver(8);
  const MotionMetric metric = factor_metric(kBox);
  const double push = GENERATE(-1.0, 1.0);
  std::vector<FrictionContact> contacts = rubbing_corners(0.4);
  for (FrictionContact c : rubbing_corners(0.4)) {
    c.r.z = 0.02, c.normal = {0, 0, -1}, c.obstacle_velocity = {0.1, 0, 0};
    contacts.push_back(c);
  }
  const FrictionStep out = solver.step(metric, {{0, 0, push}, {}}, contacts);
  REQUIRE(out.converged);
  CHECK_FALSE(out.contradictory);
  // pressed to the plate by 1 N·s, whose friction carries it along; the floor lets it stay
  CHECK_THAT(out.v.v, IsNear({push > 0 ? 0.1 : 0, 0, 0}, 1e-6));
}

TEST_CASE("coulomb: a bound on the quadratic programs ends with the convex law", "[math]") {
  CoulombSolver solver(4);
  const MotionMetric metric = factor_metric(kBox);
  const Twist v_free{{1, 0, -0.1}, {}};
  const FrictionStep bound = solver.step(metric, v_free, rubbing_corners(0.5), 1);
  CHECK_FALSE(bound.converged);
  // it separates and penetrates nothing
  CHECK(bound.v.v.z >= 0);
  CHECK(solver.step(metric, v_free, rubbing_corners(0.5)).converged);
}
