// SPDX-License-Identifier: GPL-3.0-or-later
// The drivers of HID devices as a session opens them, by udev and hidapi, at emulated nodes, in
// real time. Nothing here depends on how fast this machine is.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "clients/desk/trial/byte_record.h"
#include "device-io/device.h"
#include "device-io/emulator/emulated_hid_arm.h"
#include "device-io/emulator/emulated_spacemouse.h"
#include "device-io/plugged/find_node.h"
#include "device-io/plugged/send_release.h"
#include "device-io/spacemouse/spacemouse.h"
#include "proto/os/realtime.h"
#include "tests/support/usb/packet_replay.h"
#include "tests/support/usb/umock_hidraw.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

constexpr auto kTick = std::chrono::milliseconds(1);
constexpr int kPatience = 20'000;  // ticks, for a machine that is busy

/// Ticks the device until `done`, with this force.
bool run_until(Device& device, DeviceState& state, const Wrench& F_B,
               const std::function<bool()>& done) {
  for (int i = 0; i < kPatience; ++i) {
    const int64_t t_ns = now_ns();
    device.read({t_ns, t_ns}, state);
    device.write(F_B);
    if (done()) return true;
    std::this_thread::sleep_for(kTick);
  }
  return false;
}

DeviceConfig of_kind(DeviceKind kind) {
  DeviceConfig config;
  config.kind = kind;
  return config;
}

EmulatedHidArmOptions resting_arm() {
  EmulatedHidArmOptions options;
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  return options;
}

}  // namespace

TEST_CASE("umock: a WoodenHaptics over HID is found, read, driven and let go of", "[umock]") {
  EmulatedHidArm arm(resting_arm());
  UmockHidraw node(arm);
  const DeviceConfig config = of_kind(DeviceKind::kHidArm);
  CHECK(find_node(config) == "/dev/hidraw0");
  FileDescriptor held = open_node(config);
  auto device = open_device(config);
  DeviceState state{};
  const auto current = [&] {
    return node.with_device([&] { return std::abs(arm.milliamperes()[1]); });
  };
  CHECK(run_until(*device, state, {{0, 0, 1}, {}}, [&] { return current() > 100; }));
  CHECK((state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
  CHECK(norm(state.X_BH.p - node.with_device([&] { return arm.plant().p_B; })) < 0.01);
  device->stop();
  CHECK(run_until(*device, state, {}, [&] { return current() == 0; }));
  // as hapticd lets go of it, over its own descriptor
  const uint64_t before = node.with_device([&] { return arm.commands(); });
  CHECK(send_release(held.get(), device->release()));
  CHECK(node.with_device([&] { return arm.commands(); }) > before);
  node.unplug();
  CHECK(run_until(*device, state, {}, [&] { return (state.flags & kDeviceLost) != 0; }));
  CHECK_THROWS_WITH(find_node(config), Contains("is plugged in"));
}

TEST_CASE("umock: a HID arm's half reports, lost ones and old ones end in sense or in zero",
          "[umock]") {
  EmulatedHidArm arm(resting_arm());
  UmockHidraw node(arm);
  auto device = open_device(of_kind(DeviceKind::kHidArm));
  DeviceState state{};
  const auto is_good = [&] {
    constexpr uint32_t kBad = kDeviceLost | kDeviceStale | kDeviceNoisy;
    return (state.flags & (kBad | kDeviceFresh)) == kDeviceFresh;
  };
  REQUIRE(run_until(*device, state, {}, is_good));
  const auto fault =
      GENERATE(EmulatorFault::kHalves, EmulatorFault::kLoses, EmulatorFault::kOldFirst);
  node.with_device([&] { arm.lie(fault); });
  // half of the reports are none; a lost one is a step of the counter; an old one is a lie
  const uint32_t found = fault == EmulatorFault::kHalves     ? kDeviceLost
                         : fault == EmulatorFault::kOldFirst ? kDeviceStale
                                                             : kDeviceFresh;
  CHECK(run_until(*device, state, {{0, 0, 1}, {}}, [&] { return (state.flags & found) != 0; }));
  CHECK(is_finite(state.X_BH.p));
  node.with_device([&] { arm.lie(EmulatorFault::kHealthy); });
  CHECK(run_until(*device, state, {}, is_good));
}

TEST_CASE("umock: what a HID arm says is recorded, and played to its driver again", "[umock]") {
  ByteRecord record;
  DeviceState state{};
  {
    EmulatedHidArm arm(resting_arm());
    UmockHidraw node(arm);
    auto device = open_device(of_kind(DeviceKind::kHidArm));
    REQUIRE(record.listen_to(*device));
    int ticks = 0;
    run_until(*device, state, {{0, 0, 1}, {}}, [&] { return ++ticks > 200; });
  }
  const ReplayedPackets replayed = replay_hid_arm(record.pieces());
  REQUIRE(replayed.samples.size() > 20);
  CHECK(replayed.mismatches == 0);
  CHECK(replayed.samples.back().flags == (kDeviceFresh | kDeviceHomed));
  // to a report's way, since the driver had read at other instants
  CHECK(std::ranges::any_of(replayed.samples, [&](const DeviceState& sample) {
    return norm(sample.X_BH.p - state.X_BH.p) < 2e-4;
  }));
  const bool said = std::ranges::any_of(record.pieces(), [](const DeviceBytes& piece) {
    return !piece.by_device && piece.bytes != std::string(9, '\0');
  });
  CHECK(said);
}

TEST_CASE("umock: what a SpaceMouse says is recorded", "[umock]") {
  ByteRecord record;
  EmulatedSpaceMouseOptions options;
  options.hand = [](double) { return std::array<int, 6>{0x15e, 0, 0, 0, 0, 0}; };
  EmulatedSpaceMouse mouse(options);
  UmockHidraw node(mouse);
  DeviceConfig config = of_kind(DeviceKind::kSpaceMouse);
  config.workspace_radius = 0.05;
  auto device = open_device(config, open_node(config));
  REQUIRE(record.listen_to(*device));
  DeviceState state{};
  CHECK(run_until(*device, state, {}, [&] { return state.X_BH.p.x > 0.01; }));
  device.reset();
  REQUIRE_FALSE(record.pieces().empty());
  // played to another one, the handle goes the same way
  size_t next = 0;
  SpaceMouse again(config, "played", [&](std::span<uint8_t> report) {
    if (next == record.pieces().size()) return 0;
    const std::string& bytes = record.pieces()[next++].bytes;
    std::ranges::copy(bytes, report.begin());
    return static_cast<int>(bytes.size());
  });
  for (int64_t t_ms = 1; t_ms < 100; ++t_ms)
    again.read({t_ms * 1'000'000, t_ms * 1'000'000}, state);
  CHECK(state.X_BH.p.x > 0.001);
}

TEST_CASE("umock: ids that are anybody's need the product's name, or be vouched for", "[umock]") {
  EmulatedHidArmOptions options = resting_arm();
  options.product = "some mouse";
  EmulatedHidArm arm(options);
  UmockHidraw node(arm);
  DeviceConfig config = of_kind(DeviceKind::kHidArm);
  CHECK_THROWS_WITH(find_node(config), Contains("no woodenhaptics-hid is plugged in"));
  assign(config.plugged.serial, options.serial);
  CHECK(find_node(config) == "/dev/hidraw0");
}

TEST_CASE("umock: a SpaceMouse is found, leads the handle, rests and is unplugged", "[umock]") {
  std::atomic<int> push{350};
  EmulatedSpaceMouseOptions options;
  options.whole = GENERATE(false, true);
  options.hand = [&](double) { return std::array<int, 6>{push, 0, 0, 0, 0, 0}; };
  EmulatedSpaceMouse mouse(options);
  UmockHidraw node(mouse);
  DeviceConfig config = of_kind(DeviceKind::kSpaceMouse);
  config.workspace_radius = 0.05;
  auto device = open_device(config, open_node(config));
  DeviceState state{};
  CHECK(device->caps().max_force == 0);
  CHECK(run_until(*device, state, {}, [&] { return state.X_BH.p.x > 0.049; }));
  push = 0;
  CHECK(run_until(*device, state, {}, [&] { return state.V_BH == Twist{}; }));
  CHECK((state.flags & kDeviceLost) == 0);
  node.unplug();
  CHECK(run_until(*device, state, {}, [&] { return (state.flags & kDeviceLost) != 0; }));
}

TEST_CASE("umock: a mouse of 3Dconnexion is refused by name", "[umock]") {
  EmulatedSpaceMouseOptions options;
  options.product = 0xc650;  // a CadMouse
  EmulatedSpaceMouse mouse(options);
  UmockHidraw node(mouse);
  CHECK_THROWS_WITH(find_node(of_kind(DeviceKind::kSpaceMouse)),
                    Contains("no spacemouse is plugged in") &&
                        Contains("/dev/hidraw0 (256f:c650, SpaceMouse Wireless) is none"));
}
