// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/quasi_static.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostHalvings = 20;  // a hard contact may begin right at the start of a long step
constexpr double kEnergyRounding = 1e-14;  // relative; energies are not known any better
constexpr double kStillTurning = 1e-3;     // first regularisation, relative to the stiffness

struct Balance {
  BodyWrench sum;
  double scale = 0;  // the largest force that acts [N]
};

double strength(const Wrench& F, double radius) {
  return norm(F.f) + norm(F.t) / radius;
}

Balance balance_at(const Coupling& coupling, const ToolBody& tool, const Pose& X_WT,
                   std::span<const SoftContact> contacts, const Pose& X_WC) {
  const BodyMotion rest{X_WC, {}};
  Balance b;
  b.sum = coupling_wrench(coupling, tool, {X_WT, {}}, rest);
  b.scale = strength(b.sum.F_W, tool.radius);
  const BodyWrench touched = soft_contact_wrench(contacts, rest);
  b.scale = std::max(b.scale, strength(touched.F_W, tool.radius));
  b.sum.F_W = b.sum.F_W + touched.F_W;
  b.sum.by_motion += touched.by_motion;
  b.sum.energy += touched.energy;
  return b;
}

double energy_at(const Coupling& coupling, const ToolBody& tool, const Pose& X_WT,
                 std::span<const SoftContact> contacts, const Pose& X_WC) {
  const BodyMotion rest{X_WC, {}};
  return coupling_energy(coupling, {X_WT, {}}, motion_of_tool(tool, rest)) +
         soft_contact_energy(contacts, rest);
}

/// The Newton step. Where the matrix is not positive definite along the force, a growing stiffness
/// is added until the step leads downhill.
Twist descent(const BodyWrench& at, double radius, double stiffness) {
  HAPTIC_ASSERT(!(stiffness <= 0));
  Mat6 K = -1.0 * at.by_motion;
  for (double added = 0; added <= stiffness;
       added = std::max(10 * added, kStillTurning * stiffness)) {
    Mat6 regular = K;
    add_block(regular, 0, 0, added * Mat3{});
    add_block(regular, 3, 3, added * radius * radius * Mat3{});
    Twist step;
    if (solve(regular, at.F_W, step) && dot(at.F_W, step) > 0) return step;
  }
  return {(1 / stiffness) * at.F_W.f, (1 / (stiffness * radius * radius)) * at.F_W.t};
}

/// Nothing touches, neither here nor at the hand, and the way there is within the trust region.
bool is_free(const ToolBody& tool, const Pose& X_WC, const Pose& X_hand,
             std::span<const SoftContact> contacts, const QuasiStaticStep& step) {
  for (const SoftContact& c : contacts) {
    if (c.stiffness > 0 && (gap_of(c, X_WC) < 0 || gap_of(c, X_hand) < 0)) return false;
  }
  const Twist way{X_hand.p - X_WC.p, to_rotation_vector(X_hand.q * conjugate(X_WC.q))};
  return !(step.max_travel > 0) || !limit_travel(way, tool.radius, step.max_travel).was_cut;
}

double largest_stiffness(const Coupling& coupling, std::span<const SoftContact> contacts) {
  double sum = coupling.translational_stiffness;
  for (const SoftContact& c : contacts) sum += c.stiffness;
  return std::max(sum, 1e-9);
}

}  // namespace

QuasiStaticResult solve_quasi_static(const Coupling& coupling, const ToolBody& tool,
                                     const Pose& X_WT, std::span<const SoftContact> contacts,
                                     const Pose& X_WP, const QuasiStaticStep& step) {
  HAPTIC_ASSERT(step.max_iterations >= 0 && step.tolerance >= 0);
  const Pose X_hand = motion_of_centre(tool, {X_WT, {}}).X_WC;
  Pose X_WC = motion_of_centre(tool, {X_WP, {}}).X_WC;
  const double stiffness = largest_stiffness(coupling, contacts);
  QuasiStaticResult result;
  Balance here = balance_at(coupling, tool, X_WT, contacts, X_WC);
  for (;; ++result.iterations) {
    if (is_free(tool, X_WC, X_hand, contacts, step)) return {X_WT, result.iterations, 0, true};
    result.residual = strength(here.sum.F_W, tool.radius);
    result.converged = result.residual <= step.tolerance * here.scale;
    if (result.converged || result.iterations == step.max_iterations) break;
    Twist way = descent(here.sum, tool.radius, stiffness);
    if (step.max_travel > 0) way = limit_travel(way, tool.radius, step.max_travel).motion;
    bool sinks = false;
    for (int k = 0; k <= kMostHalvings && !sinks; ++k) {
      const double share = std::ldexp(1.0, -k);
      const Pose X_there = moved(X_WC, {share * way.v, share * way.w});
      sinks = energy_at(coupling, tool, X_WT, contacts, X_there) <=
              here.sum.energy * (1 + kEnergyRounding);
      if (sinks) X_WC = X_there;
    }
    if (!sinks) break;
    here = balance_at(coupling, tool, X_WT, contacts, X_WC);
  }
  result.X_WP = tool_of_centre(tool, X_WC);
  return result;
}

}  // namespace haptic
