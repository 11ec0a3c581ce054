// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions with a device that has no actuators: configs/spacemouse.toml in lockstep. And what its
// servo side does in a tick, under the guard.
#include <catch2/catch.hpp>
#include <cstring>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/emulator/emulated_spacemouse.h"
#include "device-io/spacemouse/spacemouse.h"
#include "proto/config/config.h"
#include "tests/support/data.h"
#include "tests/support/guarded.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Pushed down for two seconds, then to the right.
std::array<int, 6> down_and_aside(double t) {
  return t < 2 ? std::array<int, 6>{0, 0, 350, 0, 0, 0} : std::array<int, 6>{150, 0, 0, 0, 0, 0};
}

struct Run {
  int touching = 0;
  double deepest = 0, strongest = 0, highest_proxy = 0;
  uint32_t flags = 0;
  uint64_t hash = 0;
};

Run play() {
  const SessionConfig config = load_config(from_source("configs/spacemouse.toml"));
  const BakedSession baked = bake_session(config);
  EmulatedSpaceMouseOptions options;
  options.hand = down_and_aside;
  EmulatedSpaceMouse emulated(options);
  int64_t t_ns = 1'000'000'000;
  SpaceMouse device(config.device, "emulated", [&](std::span<uint8_t> report) {
    UsbBytes packet;
    if (!emulated.give(0x81, report.size(), packet, t_ns)) return 0;
    std::memcpy(report.data(), packet.data(), packet.size());
    return static_cast<int>(packet.size());
  });
  Lockstep lockstep(config, baked.shapes(), device);
  lockstep.control().armed = 1;
  Run run;
  for (int i = 0; i < 2500; ++i) {
    t_ns += 1'000'000;
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    run.touching += (f.flags & kServoContact) != 0;
    run.deepest = std::max(run.deepest, -f.device.X_BH.p.y);
    run.strongest = std::max({run.strongest, norm(f.F_device_B.f), norm(f.F_device_B.t)});
    if ((f.flags & kServoContact) != 0) {
      run.highest_proxy = std::max(run.highest_proxy, std::fabs(f.X_WP.p.y));
    }
    run.flags |= f.flags;
  }
  run.hash = lockstep.hash();
  return run;
}

}  // namespace

TEST_CASE("spacemouse: a session shows contacts, and the force at the device is zero",
          "[device-io]") {
  const Run run = play();
  CHECK(run.touching > 1000);
  CHECK(run.deepest > 0.03);
  CHECK(run.highest_proxy < 1e-3);  // the proxy stays on the top of the block
  CHECK(run.strongest == 0);
  CHECK((run.flags & (kServoFault | kServoSaturated | kServoNoDevice)) == 0);
  CHECK(play().hash == run.hash);
}

TEST_CASE("spacemouse: a tick neither allocates nor waits", "[device-io]") {
  if (!hooks_are_here()) return;
  constexpr uint8_t kReport[]{1, 0x5e, 0x01, 0, 0, 0, 0, 0x20, 0, 0, 0, 0, 0};
  int asked = 0;
  DeviceConfig config;
  config.workspace_radius = 0.1;
  config.workspace_turn = 1;
  SpaceMouse device(config, "emulated", [&](std::span<uint8_t> report) {
    std::memcpy(report.data(), kReport, sizeof kReport);
    // now and then more reports than a tick takes
    return ++asked % 8 == 0 && asked % 800 > 100 ? 0 : static_cast<int>(sizeof kReport);
  });
  DeviceState state{};
  const auto run = [&](int64_t from_ms, int64_t to_ms) {
    for (int64_t t_ms = from_ms; t_ms < to_ms; ++t_ms) {
      device.read({t_ms * 1'000'000, t_ms * 1'000'000}, state);
      device.write({{1, 2, 3}, {}});
    }
  };
  // touches all memory once, as locking it does
  run(1, 1000);
  const GuardReport report = guarded([&] { run(1000, 12'000); });
  INFO(report.explain());
  CHECK(report.violations() == 0);
  CHECK(norm(state.X_BH.p) > 0.09);
}
