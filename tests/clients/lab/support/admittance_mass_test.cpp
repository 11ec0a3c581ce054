// SPDX-License-Identifier: GPL-3.0-or-later
// The least stable virtual mass: servo and simulated arm in lockstep, by bisection, against the
// roots of the loop's characteristic polynomial and against closed forms (docs/admittance.md).
#include <Eigen/Eigenvalues>
#include <numbers>

#include "contact/shape/mesh/primitives.h"
#include "device-io/hand/impedance.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/arm_session.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kT = 1e-3;

/// One axis: a mass or an inertia, with its damping and the like.
struct Axis {
  double mass = 0, damping = 0;  // of the virtual body
  double hand_stiffness = 0, hand_damping = 0, hand_mass = 0;
  int delay = 0;  // of the arm [ticks]
  bool turning = false;
};

/// Largest root of the loop's characteristic polynomial.
double spectral_radius(const Axis& a) {
  const double g = a.hand_stiffness * kT * kT / 2, b = a.hand_damping * kT, m = a.hand_mass;
  const double whole = a.mass + a.damping * kT;
  Eigen::VectorXd p = Eigen::VectorXd::Zero(a.delay + 4);  // from the constant on
  p[a.delay + 3] += whole;
  p[a.delay + 2] -= whole + a.mass;
  p[a.delay + 1] += a.mass;
  p[2] += g + b + m;
  p[1] += g - b - 2 * m;
  p[0] += m;
  const auto n = static_cast<Eigen::Index>(a.delay + 3);
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
  companion.col(n - 1) = -p.head(n) / p[n];
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}

/// True if a small step of the intention dies out, a tenth of a nanometre or nanoradian: where the
/// loop is linear.
bool dies_out(const Axis& a) {
  SessionConfig config = arm_session(Renderer::kGodObject3);
  AdmittanceConfig& body = config.device.admittance;
  SimulatedHandConfig& hand = config.device.hand;
  (a.turning ? body.inertia : body.mass) = a.mass;
  (a.turning ? body.rotational_damping : body.damping) = a.damping;
  body.arm_delay = a.delay * kT;
  hand.hand_mass = hand.hand_damping = hand.hand_stiffness = 0;
  hand.hand_inertia = hand.hand_rotational_damping = hand.hand_rotational_stiffness = 0;
  (a.turning ? hand.hand_inertia : hand.hand_mass) = a.hand_mass;
  (a.turning ? hand.hand_rotational_damping : hand.hand_damping) = a.hand_damping;
  (a.turning ? hand.hand_rotational_stiffness : hand.hand_stiffness) = a.hand_stiffness;
  const auto knocked = [&](double t) {
    const double step = t > 0.0105 ? 1e-10 : 0;
    Intent intent;
    (a.turning ? intent.q_B = from_rotation_vector({step, 0, 0}),
     Vec3{}    : intent.p_B = {step, 0, 0});
    return intent;
  };
  config.objects[0].X_WO.p = {1, 0, 0};
  ArmRun run(config, {make_box({0.1, 0.1, 0.1})}, knocked);
  double early = 0, late = 0;
  for (int k = 0; k < 3000; ++k) {
    const ServoFrame& f = run.step();
    const double speed = a.turning ? norm(f.device.V_BH.w) : norm(f.device.V_BH.v);
    // it grows, and would end at what safety and contact let through
    if (norm(f.device.X_BH.p) > 1e-7 || norm(to_rotation_vector(f.device.X_BH.q)) > 1e-7)
      return false;
    if (k >= 500 && k < 1000) early = std::max(early, speed);
    if (k >= 2500) late = std::max(late, speed);
  }
  return late < 0.99 * early || late < 1e-15;
}

double least_mass(Axis axis, const std::function<bool(const Axis&)>& is_stable) {
  double low = 1e-6, high = 1e2;
  while (high > 1.01 * low) {
    axis.mass = std::sqrt(low * high);
    (is_stable(axis) ? high : low) = axis.mass;
  }
  return std::sqrt(low * high);
}

double least_by_roots(const Axis& axis) {
  return least_mass(axis, [](const Axis& a) { return spectral_radius(a) < 1 + 1e-9; });
}

}  // namespace

TEST_CASE("admittance: the roots have the limits in closed form", "[lab]") {
  for (const int d : {0, 1, 2, 3, 5}) {
    CAPTURE(d);
    const double b = 40;
    const Axis damper{.damping = 0, .hand_damping = b, .delay = d};
    const double phi = d * std::numbers::pi / (2 * d + 1);
    CHECK(least_by_roots(damper) == Approx(b * kT / (2 * std::cos(phi))).epsilon(0.02));
  }
  const Axis axis{.damping = 5, .hand_stiffness = 300, .hand_damping = 20, .hand_mass = 0.5};
  CHECK(least_by_roots(axis) == Approx(0.5 + kT * (20 - 5) / 2).epsilon(0.02));
}

TEST_CASE("admittance: the least stable mass is that of the derivation", "[lab]") {
  const int d = GENERATE(0, 1, 2);
  const bool turning = GENERATE(false, true);
  std::vector<Axis> axes{{.damping = 1, .hand_stiffness = 10, .hand_damping = 50}};
  if (turning) axes[0] = {.damping = 1e-3, .hand_stiffness = 0.1, .hand_damping = 0.1};
  for (const size_t i : {size_t{1}, size_t{2}, size_t{4}}) {
    const HandImpedance& h = kHandImpedances[i];
    axes.push_back(turning ? Axis{.damping = 0.01,
                                  .hand_stiffness = h.rotational_stiffness,
                                  .hand_damping = h.rotational_damping,
                                  .hand_mass = h.inertia}
                           : Axis{.damping = 5,
                                  .hand_stiffness = h.stiffness,
                                  .hand_damping = h.damping,
                                  .hand_mass = h.mass});
  }
  for (Axis axis : axes) {
    axis.delay = d;
    axis.turning = turning;
    const double exact = least_by_roots(axis), found = least_mass(axis, dies_out);
    CAPTURE(d, turning, axis.hand_mass, axis.hand_damping, exact, found, found / exact);
    CHECK(found == Approx(exact).epsilon(0.05));
  }
}
