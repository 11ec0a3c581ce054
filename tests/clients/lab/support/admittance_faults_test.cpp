// SPDX-License-Identifier: GPL-3.0-or-later
// Planted faults of an admittance device: the commanded pose stops and enters nothing; and what the
// hand gets back, from the arm's own parts of a tick.
#include <algorithm>
#include <limits>

#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/admittance_ticks.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kTop = 0.05;  // of the block [m]

/// An arm whose samples and contacts a test may spoil.
struct FaultyRun {
  SessionConfig config = arm_session(Renderer::kGodObject3);
  std::function<void(uint64_t, DeviceState&)> spoil = [](uint64_t, DeviceState&) {};
  std::function<bool(uint64_t, ContactSet&)> answer = [](uint64_t, ContactSet&) { return true; };
  std::function<uint64_t(uint64_t)> skipped = [](uint64_t) -> uint64_t { return 0; };  // after it
  double deepest = -1;

  /// The hand pushes down with 20 N from 30 mm above the block; returns the last frame.
  ServoFrame run(uint64_t ticks) {
    config.safety.max_force = config.device.max_force = 20;
    config.device.hand.hand_stiffness = 100;
    const auto down = [](double t) {
      return Intent{{0, 0, t < 0.01 ? kTop + 0.03 : kTop - 0.2}, {}, {}, {}};
    };
    ArmTicks run(config, down);
    ServoFrame frame{};
    for (uint64_t k = 0; k < ticks; ++k) {
      ServoInput input = run.read(k);
      spoil(k, input.device);
      frame = run.move(input);
      REQUIRE(is_finite(frame.X_command_B));
      deepest = std::max(deepest, kTop - frame.X_command_B.p.z);
      auto next = run.answer(frame);
      if (answer(k, *next)) run.set = std::move(next);
      k += skipped(k);
    }
    return frame;
  }
};

/// Speed of the last command [m/s].
double speed_of(const ServoFrame& f) {
  return norm(f.X_command_B.p - f.device.X_BH.p) / 1e-3;
}

}  // namespace

TEST_CASE("admittance: without a fault the hand presses on the block", "[lab]") {
  FaultyRun session;
  const ServoFrame f = session.run(2000);
  CHECK(f.fault == 0);
  CHECK(session.deepest <= 1e-12);
  CHECK(f.X_command_B.p.z == Approx(kTop).margin(1e-9));
  CHECK(f.F_device_B.f.z == Approx(20).margin(0.1));
}

TEST_CASE("admittance: a wrench or a pose that is none, or jumps, stops the arm", "[lab]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Row {
    Fault fault;
    double force, step;  // added to what was measured [N], [m]
  };
  const Row row = GENERATE_COPY(
      values<Row>({{Fault::kForceNotFinite, nan, 0},
                   {Fault::kForceNotFinite, std::numeric_limits<double>::infinity(), 0},
                   {Fault::kForceHuge, -1e6, 0},
                   {Fault::kPoseJump, 0, 0.2},
                   {Fault::kDeviceNotFinite, 0, nan}}));
  CAPTURE(row.force, row.step);
  FaultyRun session;
  session.spoil = [&](uint64_t k, DeviceState& device) {
    if (k != 60) return;
    device.F_hand_B.f.z += row.force;
    device.X_BH.p.x += row.step;
  };
  const ServoFrame f = session.run(300);
  CHECK(f.fault == static_cast<uint32_t>(row.fault));
  CHECK(speed_of(f) == 0);
  CHECK(session.deepest < 0);
}

TEST_CASE("admittance: contact that is dead or late stops the arm before the block", "[lab]") {
  const uint64_t dies = GENERATE(30u, 60u, 75u, 80u, 85u, 90u, 100u);
  FaultyRun dead;
  dead.answer = [&](uint64_t k, ContactSet&) { return k < dies; };
  const ServoFrame f = dead.run(400);
  CAPTURE(dies, f.X_command_B.p.z);
  CHECK(dead.deepest <= 1e-12);
  CHECK(speed_of(f) == 0);

  FaultyRun late;
  late.answer = [](uint64_t k, ContactSet&) { return k < 3 || k % 40 == 0; };
  late.run(1500);
  CHECK(late.deepest <= 1e-12);
}

TEST_CASE("admittance: contact that lies does not throw the arm", "[lab]") {
  const bool finite = GENERATE(true, false);
  FaultyRun session;
  session.answer = [&](uint64_t k, ContactSet& set) {
    if (k < 60) return true;
    Contact lie{};
    lie.normal_O = lie.shading_normal_O = {0, 0, 1};
    // the plane is 10 cm above the tool, or nowhere
    lie.object_point_O.z = finite ? kTop + 0.13 : std::nan("");
    set.contacts.clear();
    set.contacts.push_back(lie);
    set.n_active = 1;
    return true;
  };
  const ServoFrame f = session.run(100);
  CHECK(session.deepest < 0);
  if (finite) {
    // 40 ms at 20 N on 2 kg, and what it fell with
    CHECK(f.X_command_B.p.z < kTop + 0.06);
  } else {
    CHECK(f.fault == static_cast<uint32_t>(Fault::kContactsNotFinite));
    CHECK(speed_of(f) == 0);
  }
}

TEST_CASE("admittance: without a force of the hand nothing moves", "[lab]") {
  SessionConfig config = arm_session(Renderer::kGodObject3);
  config.objects[0].X_WO.p = {1, 0, 0};
  ArmRun run(config, {make_box({0.1, 0.1, 0.1})}, [](double) {
    return Intent{{0.1, 0.2, 0.3}, {}};
  });
  for (int k = 0; k < 3000; ++k) {
    const ServoFrame& f = run.step();
    REQUIRE(f.X_command_B == Pose{{0.1, 0.2, 0.3}, {}});
    REQUIRE(f.F_device_B == Wrench{});
  }
}

TEST_CASE("admittance: after skipped ticks a hand that pushes moves the body on", "[lab]") {
  const bool skips = GENERATE(false, true);
  CAPTURE(skips);
  FaultyRun run;
  // in the middle of the way, at half a metre a second
  constexpr uint64_t kLast = 65, kGap = 10;
  run.skipped = [&](uint64_t k) -> uint64_t { return skips && k == kLast ? kGap : 0; };
  double after = 0;  // speed of the arm in the first tick after the gap [m/s]
  run.spoil = [&](uint64_t k, DeviceState& device) {
    if (k == kLast + kGap + 2) after = norm(device.V_BH.v);
  };
  run.run(400);
  // an arm that has stood still begins slowly
  CHECK((after < 0.1) == skips);
  CHECK(run.deepest > -1e-6);  // on the block
  CHECK(run.deepest < 1e-9);
}

TEST_CASE("admittance: over each second the hand gets back no more than it put in", "[lab]") {
  SessionConfig config = arm_session(Renderer::kGodObject3);
  // heavy, light, and too light for a hand that damps: 0.05 kg would be stable
  const double mass = GENERATE(2.0, 0.6, 0.03);
  const bool rings = mass < 0.05;
  config.device.admittance.mass = mass;
  config.device.hand.hand_mass = rings ? 0 : 0.5;
  config.device.hand.hand_damping = rings ? 100 : 5;
  config.safety.max_force = config.device.max_force = 20;
  const auto strokes = [](double t) {
    const double s = 0.09 * std::sin(3 * t);
    return Intent{{0.02 * std::cos(5 * t), 0, 0.06 + s}, {}, {}, {}};
  };
  ArmRun run(config, {make_box({0.1, 0.1, 0.1})}, strokes);
  double begin = 0, held = 0;
  for (int k = 1; k <= 8000; ++k) {
    const ServoFrame& f = run.step();
    if (k % 1000 != 0) continue;
    const double work = run.arm.hand_work().moving;
    // what the body holds in motion is the hand's, and is given back
    const double now = mass * norm_squared(f.device.V_BH.v) / 2;
    CAPTURE(mass, k, work - begin, held, now);
    CHECK(work - begin + held >= now - 1e-4);
    begin = work;
    held = now;
  }
}
