// SPDX-License-Identifier: GPL-3.0-or-later
// The drivers of HID devices as a session opens them, by udev and hidapi, at emulated nodes, in
// real time. Nothing here depends on how fast this machine is.
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "device-io/device.h"
#include "device-io/plugged/find_node.h"
#include "device-io/plugged/send_release.h"
#include "proto/os/realtime.h"
#include "tests/support/usb/emulated_hid_arm.h"
#include "tests/support/usb/emulated_spacemouse.h"
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
}

TEST_CASE("umock: a WoodenHaptics over HID that is unplugged is lost", "[umock]") {
  EmulatedHidArm arm(resting_arm());
  UmockHidraw node(arm);
  auto device = open_device(of_kind(DeviceKind::kHidArm));
  DeviceState state{};
  REQUIRE(run_until(*device, state, {}, [&] { return (state.flags & kDeviceFresh) != 0; }));
  node.unplug();
  CHECK(run_until(*device, state, {}, [&] { return (state.flags & kDeviceLost) != 0; }));
  CHECK_THROWS_WITH(find_node(of_kind(DeviceKind::kHidArm)), Contains("is plugged in"));
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
