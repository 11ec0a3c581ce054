// SPDX-License-Identifier: GPL-3.0-or-later
// The stiffness of the coupling is changed while a rigid tool is pressed on a block: contact and
// servo look for its pose in the metric of the springs that are in force.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "clients/lab/lockstep.h"
#include "clients/lab/scripted_hand.h"
#include "contact/bake/session.h"
#include "proto/wire/renderer.h"
#include "tests/support/over_block.h"

namespace haptic {
namespace {

constexpr double kHalf = 0.01;    // half a side of the cube that is the tool [m]
constexpr double kTilt = 0.15;    // of the hand, about y [rad]
constexpr double kHandZ = 0.007;  // of the hand above the block [m]
constexpr double kMargin = 1e-6;

struct Springs {
  double translational, rotational;
};

/// Height and tilt of a cube on one of its edges.
struct Rest {
  double z, tilt;
};

/// Where the springs leave it, on a plane at that height: the least ½ k_T (z − z_h)² + ½ k_R (θ −
/// θ_h)² with z = plane + a (sin θ + cos θ), by ternary search.
Rest rest_of(const Springs& springs, double plane) {
  const auto height = [&](double tilt) {
    return plane + kHalf * (std::sin(tilt) + std::cos(tilt));
  };
  const auto energy = [&](double tilt) {
    const double dz = height(tilt) - kHandZ, turn = tilt - kTilt;
    return springs.translational * dz * dz + springs.rotational * turn * turn;
  };
  double low = 0, high = kTilt;
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (energy(a) < energy(b) ? high : low) = energy(a) < energy(b) ? b : a;
  }
  return {height(low), low};
}

/// k_T Δz lever − k_R Δθ at that pose, over the torque: the springs' wrench passes through the edge
/// that the cube stands on.
double residual(const Springs& springs, const Pose& X_WP) {
  const double tilt = to_rotation_vector(X_WP.q).y;
  const double lever = kHalf * (std::cos(tilt) - std::sin(tilt));
  const double torque = springs.rotational * (kTilt - tilt);
  const double force = springs.translational * (X_WP.p.z - kHandZ);
  return std::fabs(force * lever - torque) / std::fabs(torque);
}

/// A hand that holds still, tilted and inside the block, after it came from above.
Pose pressing(double t) {
  constexpr double kDown = 0.2;  // [s]
  const double above = t < kDown ? 0.02 * (1 - t / kDown) : 0;
  return {{0, 0, kHandZ + above}, from_rotation_vector({0, kTilt, 0})};
}

SessionConfig cube_over_block(Renderer renderer, const Springs& springs) {
  SessionConfig config = test::over_block(renderer, "primitive:box");
  config.coupling.translational_stiffness = springs.translational;
  config.coupling.rotational_stiffness = springs.rotational;
  config.rigid.margin = kMargin;
  config.safety.soft_start = 0;
  config.safety.max_force = 1e3;
  return config;
}

}  // namespace

TEST_CASE("springs: a stiffness that changes in mid-contact reaches contact too", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const Springs before{500, 0.5};
  const Springs after = GENERATE(Springs{5000, 0.5}, Springs{500, 5}, Springs{5000, 5});
  const SessionConfig config = cube_over_block(renderer, before);
  const BakedSession baked = bake_session(config);
  ScriptedHand hand{std::function<Pose(double)>(pressing)};
  Lockstep lockstep(config, baked.shapes(), hand);
  CAPTURE(row_of(renderer).name, after.translational, after.rotational);
  double largest_step = 0;
  Vec3 held_B;
  const auto settle = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) {
      REQUIRE(lockstep.step());
      largest_step = std::max(largest_step, norm(hand.held.f - held_B));
      held_B = hand.held.f;
    }
  };
  const auto check = [&](const Springs& springs) {
    REQUIRE(lockstep.contacts() != nullptr);
    const Pose &X_WG = lockstep.contacts()->X_WG, &X_WP = lockstep.frame().X_WP;
    const Rest rest = rest_of(springs, kMargin);
    CAPTURE(rest.z, rest.tilt, X_WG.p.z, X_WP.p.z);
    CHECK(std::fabs(X_WG.p.z - rest.z) < kMargin);
    CHECK(std::fabs(to_rotation_vector(X_WG.q).y - rest.tilt) < kMargin / kHalf);
    std::printf("%s %g %g: contact %.2g, servo %.2g, apart %.2g m, %.2g rad\n",
                row_of(renderer).name.data(), springs.translational, springs.rotational,
                residual(springs, X_WG), residual(springs, X_WP), norm(X_WG.p - X_WP.p),
                norm(to_rotation_vector(X_WG.q * conjugate(X_WP.q))));
    CHECK(residual(springs, X_WP) < 1e-9);
  };
  settle(1000);
  check(before);
  largest_step = 0;
  lockstep.control().translational_stiffness = after.translational;
  lockstep.control().rotational_stiffness = after.rotational;
  ++lockstep.control().revision;
  settle(1500);
  check(after);
  CHECK(largest_step <= config.safety.slew / config.servo_rate);
}

}  // namespace haptic
