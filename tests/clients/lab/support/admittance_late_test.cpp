// SPDX-License-Identifier: GPL-3.0-or-later
// An admittance device on a busy machine: ticks that come late, and ticks that are skipped after
// them. In free space a hand that pushes moves the body all the same.
#include <algorithm>

#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/admittance_ticks.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kTickNs = 1'000'000;
constexpr double kPush = 3;         // a hand that pushes [N]
constexpr double kMoving = 0.5e-3;  // a body that moves [m/s]

/// The lateness of the ticks of a run.
struct Lateness {
  double share = 0;      // of the ticks that are late
  int64_t most_ns = 0;   // late by up to this
  double arm_delay = 0;  // [s]
  uint64_t seed = 1;
};

struct Found {
  int longest_rest = 0;  // the body at rest under a hand that pushes [ms]
  int pushing = 0;       // [ticks]
  int late = 0, skipped = 0;
  uint32_t fault = 0;
  double fastest = 0;  // of the arm [m/s]
};

/// A hand with half a kilogramme that strokes through free space, as in `hapt demo admittance`.
SessionConfig free_session() {
  SessionConfig config = arm_session(Renderer::kGodObject3);
  config.safety.max_force = config.device.max_force = 20;
  config.safety.velocity_limit = 2;
  config.device.admittance.mass = 2;
  config.device.admittance.damping = 5;
  config.device.hand.hand_mass = 0.5;
  config.device.hand.hand_damping = 20;
  config.device.hand.hand_stiffness = 300;
  config.objects[0].X_WO.p = {1, 0, 0};
  return config;
}

Intent stroke(double t) {
  Intent intent;
  intent.p_B = {0.08 * std::sin(4 * t), 0.06 * std::sin(2.7 * t), 0.05 * std::cos(3.1 * t)};
  return intent;
}

Found run_late(const Lateness& lateness, int64_t duration_ns) {
  SessionConfig config = free_session();
  config.device.admittance.arm_delay = lateness.arm_delay;
  ArmTicks run(config, stroke);
  Random random(lateness.seed);
  Found found;
  int rest = 0;
  uint64_t skipped = 0;
  for (uint64_t k = 0; static_cast<int64_t>(k) * kTickNs < duration_ns;) {
    const bool is_late = random.uniform(0, 1) < lateness.share;
    const double late = is_late ? random.uniform(0, 1) * static_cast<double>(lateness.most_ns) : 0;
    ServoInput input = run.read(k, static_cast<int64_t>(late));
    input.skipped = skipped;
    const ServoFrame f = run.move(input);
    run.set = run.answer(f);

    const bool pushes = k > 100 && norm(f.device.F_hand_B.f) > kPush;
    const bool moves = norm(run.servo->admittance.body.V_BH.v) > kMoving;
    found.pushing += pushes;
    found.late += is_late;
    found.fault |= f.fault;
    found.fastest = std::max(found.fastest, norm(f.device.V_BH.v));
    // the clock goes on at the next point of the grid that is not past yet
    const auto past = static_cast<uint64_t>(input.wake_late_ns / kTickNs);
    rest = pushes && !moves ? rest + 1 + static_cast<int>(past) : 0;
    found.longest_rest = std::max(found.longest_rest, rest);
    skipped += past;
    found.skipped += static_cast<int>(past);
    k += 1 + past;
  }
  return found;
}

}  // namespace

TEST_CASE("admittance: a hand that pushes moves the body on a busy machine", "[lab]") {
  // late within a tick, as far as the arm's delay makes it even; late by some ticks, which are then
  // skipped
  const double share = GENERATE(0.03, 0.3);
  const int64_t most_ns = GENERATE(950'000, 8'000'000);
  const double arm_delay = GENERATE(1e-3, 3e-3);
  const uint64_t seed = GENERATE(1u, 2u);
  const Found found = run_late({share, most_ns, arm_delay, seed}, 8'000'000'000);
  CAPTURE(share, most_ns, arm_delay, seed, found.pushing, found.late, found.skipped, found.fastest);
  CHECK(found.fault == 0);
  CHECK(found.pushing > 2000);
  CHECK(found.longest_rest <= 50);
}
