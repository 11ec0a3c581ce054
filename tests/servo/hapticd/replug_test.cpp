// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/device_guard.cpp with a device of umockdev that comes back as another
// node.
#include <catch2/catch.hpp>
#include <filesystem>

#include "proto/config/devices.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/device_guard.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/usb/plugged_bed.h"

namespace haptic {
namespace {

using test::BedDevice;

/// A HID arm with that serial number.
BedDevice arm(const std::string& port, const std::string& serial) {
  return {port, "1234", "0006", serial, "mbed", "HID DEVICE"};
}

/// The next change, looked for once a tenth of a second for two seconds of a guard's time.
DeviceGuard::Change next_change(DeviceGuard& guard, int64_t& t_ns) {
  constexpr int64_t kStepNs = 100'000'000;
  for (int i = 0; i < 20; ++i) {
    t_ns += kStepNs;
    const DeviceGuard::Change change = guard.look(t_ns);
    if (change != DeviceGuard::Change::kNone) return change;
  }
  return DeviceGuard::Change::kNone;
}

}  // namespace

TEST_CASE("device guard: a device that was unplugged is found at its new node, not another one") {
  test::PluggedBed bed;
  const BedDevice first = arm("1-1", "A"), second = arm("1-2", "B");
  CHECK(bed.plug_hid(first, "004", "hidraw0") == "/dev/hidraw0");
  bed.plug_hid(second, "005", "hidraw1");
  const test::TemporaryRuntimeFolder folder;
  HandoutServer server("replug");
  const auto attachments = std::make_unique<Attachments>(connect_session("replug"));
  SessionConfig config{};
  config.device.kind = DeviceKind::kHidArm;
  assign(config.device.plugged.serial, std::string("A"));
  DeviceGuard guard(config, *attachments);
  CHECK(guard.path() == "/dev/hidraw0");
  int64_t t_ns = now_ns();
  CHECK(next_change(guard, t_ns) == DeviceGuard::Change::kNone);

  bed.unplug_hid(first, "hidraw0");
  CHECK(next_change(guard, t_ns) == DeviceGuard::Change::kGone);
  CHECK(guard.node() < 0);
  // the other one of its kind is not taken for it
  CHECK(next_change(guard, t_ns) == DeviceGuard::Change::kNone);
  bed.plug_hid(arm("1-4", "A"), "006", "hidraw7");
  CHECK(next_change(guard, t_ns) == DeviceGuard::Change::kBack);
  CHECK(guard.path() == "/dev/hidraw7");
  CHECK(guard.node() >= 0);
}

TEST_CASE("device guard: a servo is given no node of a USB device that is gone") {
  test::PluggedBed bed;
  const BedDevice falcon{"1-1", "0403", "cb48", "", "", "Falcon"};
  const std::string node = bed.plug_usb(falcon, "004");
  const test::TemporaryRuntimeFolder folder;
  HandoutServer server("gone");
  const auto attachments = std::make_unique<Attachments>(connect_session("gone"));
  SessionConfig config{};
  config.device.kind = DeviceKind::kFalcon;
  DeviceGuard guard(config, *attachments);
  CHECK(guard.node_for_servo() >= 0);
  guard.watch(-1, 1);  // a first servo, which has used the node
  bed.unplug(falcon);
  std::filesystem::remove(bed.root() + node);
  CHECK_THROWS_WITH(guard.node_for_servo(), Catch::Contains(node));
  CHECK(guard.node() < 0);
}

}  // namespace haptic
