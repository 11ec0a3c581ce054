// SPDX-License-Identifier: GPL-3.0-or-later
// The servo's own loop with each driver attached, under rt_guard: 5,000 ticks here, 10⁶ with
// HAPTIC_TORTURE_SCALE=200, with one driver by -c KIND. The emulated devices hold hands that press
// into the block of the shipped session files.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "clients/lab/selftest/guarded_loop.h"
#include "contact/bake/session.h"
#include "device-io/emulator/emulated_haply.h"
#include "device-io/emulator/emulated_spacemouse.h"
#include "device-io/hand/impedance.h"
#include "device-io/haply/haply.h"
#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "tests/clients/lab/selftest/played_device.h"
#include "tests/support/data.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/falcon_bench.h"
#include "tests/support/driver/hid_arm_bench.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using namespace test;

constexpr int64_t kVirtualStartNs = 1'001'000'000;  // of the emulated devices' clocks

/// A typical hand that presses 8 mm below a place of B, along `out`, and strokes a little.
SimulatedHandConfig pressing(const Vec3& at_B, const Vec3& out_B) {
  SimulatedHandConfig hand;
  hand.mass = 0.2;
  hand.damping = 0.5;
  hand.coulomb_friction = 0.1;
  hand.inertia = 1e-4;
  put_into_hand(*find_hand("typical"), hand);
  hand.intent.centre_B = at_B - 0.008 * out_B;
  hand.intent.direction_B = out_B;
  hand.intent.hover_radius = hand.intent.press_radius = hand.intent.stroke_angle = 0;
  return hand;
}

struct SocketPair {
  FileDescriptor device, driver;

  explicit SocketPair(int type) {
    int ends[2];
    if (socketpair(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) {
      throw std::runtime_error("no pair of sockets");
    }
    device = FileDescriptor(ends[0]);
    driver = FileDescriptor(ends[1]);
  }
};

GuardedDevice played(std::unique_ptr<DriverBench> bench) {
  DriverBench* const device = bench.get();
  const auto pass = [device](int64_t t_ns) { device->pass(t_ns); };
  return {std::make_unique<PlayedDevice>(std::move(bench), pass, device->t_ns() + kMs),
          device->node()};
}

template <const Arm& (*arm)()>
GuardedDevice line_device(const DeviceConfig& config) {
  return played(open_line<arm>(pressing({}, {0, 0, 1}), config));
}

GuardedDevice falcon_device(const DeviceConfig& config) {
  EmulatedFalconOptions options;
  options.hand = pressing({}, {0, 1, 0});
  return played(std::make_unique<FalconBench>(options, config));
}

GuardedDevice hid_arm_device(const DeviceConfig& config) {
  EmulatedHidArmOptions options;
  options.hand = pressing({}, {0, 0, 1});
  options.arm = config.hid_arm;
  return played(std::make_unique<HidArmBench>(options, config));
}

/// Pushed down for three seconds in four, else to the right and up.
GuardedDevice spacemouse_device(const DeviceConfig& config) {
  EmulatedSpaceMouseOptions options;
  options.hand = [](double t) {
    const double since = t - 4 * std::floor(t / 4);
    return since < 3 ? std::array<int, 6>{0, 0, 350, 0, 0, 90} : std::array{80, 0, -350, 0, 0, 0};
  };
  auto mouse = std::make_shared<EmulatedSpaceMouse>(options);
  auto wire = std::make_shared<SocketPair>(SOCK_SEQPACKET);
  const int node = wire->driver.get();
  auto driver = open_device(config, std::move(wire->driver));
  const auto pass = [mouse, wire](int64_t t_ns) {
    UsbBytes report;
    while (mouse->give(0x81, 64, report, t_ns)) {
      if (send(wire->device.get(), report.data(), report.size(), 0) < 0) break;
    }
  };
  return {std::make_unique<PlayedDevice>(std::move(driver), pass, kVirtualStartNs), node};
}

/// The board answers its driver's greeting in real time, then on the loop's time: it is asked just
/// after the tick before.
GuardedDevice haply_device(const DeviceConfig& config) {
  EmulatedHaplyOptions options;
  options.hand = pressing({0, 0.08, 0}, {0, -1, 0});
  options.arm = config.pantograph;
  auto board = std::make_shared<EmulatedHaply>(options);
  auto wire = std::make_shared<SocketPair>(SOCK_STREAM);
  auto pass = [board, wire, passed_ns = int64_t{0}](int64_t t_ns) mutable {
    std::array<uint8_t, 256> bytes;
    const ssize_t n = read(wire->device.get(), bytes.data(), bytes.size());
    if (n > 0) board->take({bytes.data(), static_cast<size_t>(n)}, std::max(passed_ns, t_ns - kMs));
    passed_ns = t_ns;
    const EmulatedHaply::Bytes said = board->give(t_ns);
    if (!said.empty() && send(wire->device.get(), said.data(), said.size(), 0) < 0) return;
  };
  const int node = wire->driver.get();
  std::jthread greets([&](const std::stop_token& stop) {
    for (; !stop.stop_requested(); usleep(200)) pass(now_ns());
  });
  auto driver = open_device(config, std::move(wire->driver));
  greets = {};
  return {std::make_unique<PlayedDevice>(std::move(driver), pass, 0), node};
}

struct Driver {
  DeviceKind kind;
  const char* session;  // in configs/
  std::function<GuardedDevice(const DeviceConfig&)> open;
};

const std::vector<Driver>& drivers() {
  static const std::vector<Driver> kAll{
      {DeviceKind::kWoodenHaptics, "woodenhaptics.toml", line_device<&woodenhaptics_arm>},
      {DeviceKind::kSixMotors, "own-device.toml", line_device<&six_motors_arm>},
      {DeviceKind::kOwnDevice, "own-device.toml", line_device<&own_device_arm>},
      {DeviceKind::kPolhem, "polhem.toml", line_device<&polhem_arm>},
      {DeviceKind::kFalcon, "falcon.toml", falcon_device},
      {DeviceKind::kHidArm, "woodenhaptics-hid.toml", hid_arm_device},
      {DeviceKind::kSpaceMouse, "spacemouse.toml", spacemouse_device},
      {DeviceKind::kHaply, "haply.toml", haply_device},
  };
  return kAll;
}

void check_guarded(const Driver& driver) {
  SessionConfig config = load_config(from_source(std::string("configs/") + driver.session));
  config.device.kind = driver.kind;
  config.safety.armed_at_start = 1;
  // a light arm is held up as well
  config.device.gravity.handle.mass = 0.01;
  for (LinkMass& link : config.device.gravity.links) link = {0.01, {0.05, 0, 0}};
  const BakedSession baked = bake_session(config);
  PlayedDevice* played = nullptr;
  GuardedLoopOptions options{
      .ticks = static_cast<uint64_t>(5'000 * torture_scale()), .timed_ticks = 0, .warm_up = 1500};
  options.open = [&](const DeviceConfig& device) {
    GuardedDevice guarded = driver.open(device);
    played = static_cast<PlayedDevice*>(guarded.device.get());
    return guarded;
  };
  uint64_t fresh = 0;
  options.also_do = [&](uint64_t) { fresh = played->fresh(); };
  const GuardedLoopResult result = run_guarded_loop(config, baked.shapes(), options);
  CAPTURE(row_of(driver.kind).name, result.report.explain());
  CHECK(result.report.violations() == 0);
  CHECK(result.lost_ticks == 0);
  CHECK(result.contact_ticks > result.ticks / 3);
  CHECK(fresh > (result.ticks + options.warm_up) * 8 / 10);
  if (torture_scale() > 1) {
    std::printf("%s: %llu ticks under guard, %llu in contact, %llu violations\n",
                std::string(row_of(driver.kind).name).c_str(),
                static_cast<unsigned long long>(result.ticks),
                static_cast<unsigned long long>(result.contact_ticks),
                static_cast<unsigned long long>(result.report.violations()));
  }
}

}  // namespace

TEST_CASE("driver guard: the servo with each driver neither allocates, locks nor calls the system",
          "[device-io]") {
  if (!guard_hooks_linked()) {
    WARN("SKIPPED: sanitizers interpose the same functions");
    return;
  }
  for (const Driver& driver : drivers()) {
    DYNAMIC_SECTION(row_of(driver.kind).name) {
      check_guarded(driver);
    }
  }
}

TEST_CASE("driver guard: each device with a node is among them", "[device-io]") {
  for (const DeviceRow& row : kDevices) {
    CAPTURE(row.name);
    CHECK(row.has_node() == std::ranges::any_of(drivers(), [&](const Driver& driver) {
            return driver.kind == row.id;
          }));
  }
}

}  // namespace haptic
