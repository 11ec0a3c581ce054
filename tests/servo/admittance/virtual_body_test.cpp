// SPDX-License-Identifier: GPL-3.0-or-later
// The virtual body against what Newton's law says of it in closed form.
#include "servo/admittance/virtual_body.h"

#include <cmath>

#include "proto/math/motion_metric.h"
#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

AdmittanceConfig body_of(double mass, double damping, double inertia, double turning) {
  AdmittanceConfig model;
  model.mass = mass;
  model.damping = damping;
  model.inertia = inertia;
  model.rotational_damping = turning;
  return model;
}

}  // namespace

TEST_CASE("admittance body: under a constant wrench it nears F/D with time constant M/D",
          "[servo]") {
  const AdmittanceConfig model = body_of(2, 10, 4e-3, 0.04);  // 0.2 s and 0.1 s
  VirtualBody body;
  const Wrench F{{3, 0, -4}, {0, 0.02, 0}};
  for (int k = 1; k <= 1000; ++k) {
    body = stepped(model, body, F, kTick);
    if (k != 200 && k != 1000) continue;
    const double t = k * kTick;
    // the implicit step is half a tick off, of 200 and of 100 to a time constant
    const double moving = 1 - std::exp(-t / 0.2), turning = 1 - std::exp(-t / 0.1);
    CHECK_THAT(body.V_BH.v, IsNear(moving * Vec3{0.3, 0, -0.4}, 0.5 * 0.003));
    CHECK_THAT(body.V_BH.w, IsNear(turning * Vec3{0, 0.5, 0}, 0.5 * 0.006));
    // x = v∞ (t − τ (1 − e^(−t/τ)))
    CHECK_THAT(body.X_BH.p, IsNear((t - 0.2 * moving) * Vec3{0.3, 0, -0.4}, 0.5e-3));
    CHECK_THAT(to_rotation_vector(body.X_BH.q),
               IsNear((t - 0.1 * turning) * Vec3{0, 0.5, 0}, 0.5e-3));
  }
}

TEST_CASE("admittance body: a huge damping stops it, and does not make it swing", "[servo]") {
  const VirtualBody fast{{}, {{1, 0, 0}, {0, 0, 5}}};
  const VirtualBody body = stepped(body_of(1, 1e9, 1e-3, 1e9), fast, {}, kTick);
  CHECK(body.V_BH.v.x >= 0);
  CHECK(body.V_BH.v.x < 1e-5);
  CHECK(body.V_BH.w.z >= 0);
  CHECK(body.V_BH.w.z < 1e-5);
}

TEST_CASE("admittance body: a brake takes m v / F to rest, and never turns it round", "[servo]") {
  const AdmittanceConfig model = body_of(2, 0, 4e-3, 0);
  VirtualBody body{{}, {{0, 0.3, 0.4}, {2, 0, 0}}};
  // 2 kg at 0.5 m/s and 20 N: 50 ms, 12.5 mm; 4e-3 kg·m² at 2 rad/s and 0.1 N·m: 80 ms, 80 mrad
  int moving = 0, turning = 0;
  for (int k = 0; k < 200; ++k) {
    body = braked(model, body, 20, 0.1, kTick);
    moving += body.V_BH.v != Vec3{};
    turning += body.V_BH.w != Vec3{};
    CHECK(body.V_BH.v.y >= 0);
    CHECK(body.V_BH.w.x >= 0);
  }
  CHECK(moving == Approx(50).margin(1));
  CHECK(turning == Approx(80).margin(1));
  CHECK_THAT(body.X_BH.p, IsNear({0, 0.0075, 0.01}, 0.3e-3));
  CHECK_THAT(to_rotation_vector(body.X_BH.q), IsNear({0.08, 0, 0}, 1.1e-3));
}

TEST_CASE("admittance body: a step is shortened to the speed limits, each by its own", "[servo]") {
  const VirtualBody from{{{1, 2, 3}, {}}, {}};
  const Twist V{{3, 0, 4}, {0, 1, 0}};
  const VirtualBody to{moved(from.X_BH, kTick * V), V};
  const VirtualBody cut = bounded(from, to, {1, 2}, kTick);
  CHECK_THAT(cut.V_BH.v, IsNear({0.6, 0, 0.8}, 1e-12));
  CHECK_THAT(cut.X_BH.p, IsNear({1.0006, 2, 3.0008}, 1e-12));
  CHECK_THAT(cut.V_BH.w, IsNear({0, 1, 0}, 1e-12));
  const VirtualBody whole = bounded(from, to, {5.1, 1.1}, kTick);
  CHECK(whole.X_BH == to.X_BH);
  CHECK(whole.V_BH.v == to.V_BH.v);
}

TEST_CASE("admittance body: brought to a pose, it has the velocity of that step", "[servo]") {
  const VirtualBody from{{{0.1, 0, 0}, {}}, {{9, 9, 9}, {}}};
  const Pose to{{0.1, 0.0005, 0}, from_rotation_vector({0, 0, 0.002})};
  const VirtualBody body = brought_to(from, to, kTick);
  CHECK(body.X_BH == to);
  CHECK_THAT(body.V_BH.v, IsNear({0, 0.5, 0}, 1e-9));
  CHECK_THAT(body.V_BH.w, IsNear({0, 0, 2}, 1e-9));
}

TEST_CASE("admittance body: its energy", "[servo]") {
  const BodyEnergy energy = energy_of(body_of(2, 0, 4e-3, 0), {{0, 0.3, 0.4}, {0, 0, 10}});
  CHECK(energy.moving == Approx(0.25));
  CHECK(energy.turning == Approx(0.2));
}
