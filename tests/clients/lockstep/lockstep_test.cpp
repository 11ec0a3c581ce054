// SPDX-License-Identifier: GPL-3.0-or-later
// Whole sessions in lockstep: the shipped scenes, the recorded hand, and bit-identical repetition.
#include "clients/lockstep/lockstep.h"

#include "clients/report/summary.h"
#include "contact/bake/inside.h"
#include "contact/bake/session.h"
#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/log/hand_trace.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

const std::string kConfigs = from_source("configs/");

struct Stage {
  SessionConfig config;
  BakedSession baked;
  ContactShapes shapes;
  std::unique_ptr<Device> device;

  explicit Stage(SessionConfig session)
      : config(session),
        baked(bake_session(config)),
        shapes(baked.shapes()),
        device(open_device(config.device)) {}
};

uint64_t hash_of(const SessionConfig& config, const LockstepOptions& options, int ticks) {
  Stage stage(config);
  Lockstep lockstep(stage.config, stage.shapes, *stage.device, options);
  for (int k = 0; k < ticks && lockstep.step(); ++k) {
  }
  return lockstep.hash();
}

}  // namespace

TEST_CASE("lockstep: a simulated hand on a block is bit-identical on two runs", "[lab]") {
  const SessionConfig config = load_config(kConfigs + "plane.toml");
  const LockstepOptions options{GENERATE(1u, 5u), GENERATE(0u, 1u, 7u)};
  CHECK(hash_of(config, options, 3000) == hash_of(config, options, 3000));
}

TEST_CASE("lockstep: another seed is another session", "[lab]") {
  SessionConfig config = load_config(kConfigs + "plane.toml");
  const uint64_t first = hash_of(config, {}, 1000);
  config.device.hand.seed += 1;
  CHECK(hash_of(config, {}, 1000) != first);
}

TEST_CASE("lockstep: the hand explores the bunny and the verified proxy is never inside", "[lab]") {
  if (!find_mesh("bunny00.off")) return;
  Stage stage(load_config(kConfigs + "bunny.toml"));
  REQUIRE(stage.shapes.objects[0].mesh.triangles.size() == 75408);
  const InsideOracle oracle(stage.shapes.objects[0].mesh);
  const double limit = stage.config.safety.max_force;
  Lockstep lockstep(stage.config, stage.shapes, *stage.device);
  SessionData data;
  int touching = 0;
  for (int k = 0; k < 6000; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    CAPTURE(k, f.X_WG.p.x, f.X_WG.p.y, f.X_WG.p.z);
    if ((f.flags & kServoNoContactSet) == 0) REQUIRE_FALSE(oracle.inside(f.X_WG.p));
    REQUIRE(norm(f.F_device_B.f) <= limit * (1 + 1e-12));
    touching += (f.flags & kServoContact) != 0;
    data.frames.push_back(f);
  }
  CHECK(touching > 500);
  // a passive wall returns no more energy than it received
  const PortEnergy energy = port_energy(data.frames);
  CHECK(energy.into_device > 1e-3);
  CHECK(energy.net() >= 0);
}

TEST_CASE("lockstep: a rigid peg in its hole feels the same by both solvers of its contacts",
          "[lab]") {
  SessionConfig config = load_config(kConfigs + "rigid-peg.toml");
  config.renderer = Renderer::kConstrained6;
  Stage by_coulomb(config);
  config.rigid.solver = RigidSolver::kLcp;
  Stage by_lcp(config);
  Lockstep one(by_coulomb.config, by_coulomb.shapes, *by_coulomb.device);
  Lockstep other(by_lcp.config, by_lcp.shapes, *by_lcp.device);
  int touching = 0;
  double largest = 0;
  for (int k = 0; k < 3000; ++k) {
    REQUIRE(one.step());
    REQUIRE(other.step());
    CAPTURE(k);
    largest = std::max(largest, norm(one.frame().F_device_B.f));
    // equal to rounding at first; later facets are nearly parallel, of which pivoting takes one
    // (lcp.h) and the other solver both: 0.02 N, of 1.4
    const double most = k < 500 ? 1e-6 : 0.05;
    REQUIRE(norm(one.frame().F_device_B.f - other.frame().F_device_B.f) < tol(most));
    touching += (other.frame().flags & kServoContact) != 0;
  }
  CHECK(touching > 500);
  CHECK(largest > 1);
  CHECK(one.hash() != other.hash());
}

TEST_CASE("lockstep: recorded human hand against a wall, every sample, bit-identical", "[lab]") {
  const std::string name = GENERATE("m2_question1c_rigid.csv", "question1a_rigid.csv");
  SessionConfig config = load_config(kConfigs + "lever.toml");
  use_trace(config, data_file("tue-1dof-bilateral/" + name));
  config.safety.soft_start = 0;
  const auto trace = load_hand_trace(config.device.replay);
  Stage stage(config);
  const LockstepOptions options;
  Lockstep lockstep(config, stage.shapes, *stage.device, options);
  size_t frames = 0, pressed = 0, slewed = 0;
  double peak = 0, held = 0;
  const double wall = -0.002;
  while (lockstep.step()) {
    const ServoFrame& f = lockstep.frame();
    REQUIRE(frames < trace.samples.size());
    // the sample itself, not an interpolation of it
    REQUIRE(f.device.X_BH.p == trace.samples[frames].X_BH.p);
    const double depth = wall - f.X_WT.p.x;
    CAPTURE(frames, depth, f.n_contacts, f.F_device_B.f.x);
    // one recording begins inside the wall: no contact has answered its first sample yet, and the
    // force then grows by the slew limit and the hand's own motion
    if (depth > 0 && frames >= options.contact_latency) {
      ++pressed;
      REQUIRE(f.n_contacts > 0);
      const double wall_force =
          std::min(config.coupling.translational_stiffness * depth, config.safety.max_force);
      const bool slewing = (f.flags & kServoSlewing) != 0;
      slewed += slewing;
      const double moved =
          frames > 0 ? norm(f.device.X_BH.p - trace.samples[frames - 1].X_BH.p) : 0;
      const double grown =
          config.safety.slew / config.servo_rate + config.coupling.translational_stiffness * moved;
      const double exact = slewing ? held + grown : wall_force;
      REQUIRE(exact <= wall_force);
      REQUIRE(std::fabs(f.F_device_B.f.x - exact) <= tol(1e-9) * exact);
      peak = std::max(peak, f.F_device_B.f.x);
    } else {
      REQUIRE(norm(f.F_device_B.f) == 0);
    }
    held = f.F_device_B.f.x;
    ++frames;
  }
  CHECK(frames == trace.samples.size());
  const bool begins_inside = wall - trace.samples[0].X_BH.p.x > 0;
  CHECK(slewed <= (begins_inside ? 8 : 0));
  CHECK(pressed > 500);
  CHECK(peak > 2.5);
  CHECK(lockstep.hash() == hash_of(config, {}, 1 << 30));
}
