// SPDX-License-Identifier: GPL-3.0-or-later
// The whole driver of the Falcon, libusb included, at an emulated node of the kernel (umockdev).
#include <linux/usbdevice_fs.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <future>
#include <thread>

#include "clients/desk/trial/byte_record.h"
#include "device-io/device.h"
#include "device-io/emulator/emulated_falcon.h"
#include "device-io/plugged/find_node.h"
#include "device-io/plugged/send_release.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/usb/packet_replay.h"
#include "tests/support/usb/umock_usb.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

/// True below umockdev-wrapper; says so where not.
bool is_below_umockdev() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  if (preloaded != nullptr && std::strstr(preloaded, "umockdev") != nullptr) return true;
  WARN("SKIPPED: this test runs below umockdev-wrapper; ctest does so");
  return false;
}

EmulatedFalconOptions pressing() {
  EmulatedFalconOptions options;
  options.hand.mass = 0.25;
  options.hand.damping = 1;
  options.hand.hand_mass = 0.5;
  options.hand.hand_damping = 5;
  options.hand.hand_stiffness = 300;
  options.hand.intent.centre_B = {0, 0, -0.02};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = 0;
  options.has_firmware = true;
  return options;
}

struct Unref {
  void operator()(UMockdevTestbed* testbed) const { g_object_unref(testbed); }
};

/// The driver, as a servo ticks it.
struct Host {
  Host() {
    config.kind = DeviceKind::kFalcon;
    config.max_force = 8;
  }
  void open() { device = open_device(config, open_node(config)); }

  /// Ticks at 1 kHz on a wall at z = 0 until a condition holds; the number of ticks, −1: never.
  template <typename Until>
  int tick_until(int most, Until until) {
    for (int i = 0; i < most; ++i) {
      sleep_until(next_ns += kMs);
      next_ns = std::max(next_ns, now_ns() - kMs);
      const int64_t t_ns = now_ns();
      device->read({t_ns, t_ns}, state);
      if (until()) return i + 1;
      const bool open = (state.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed;
      device->write({{0, 0, open ? -500 * std::min(0.0, state.X_BH.p.z) : 0}, {}});
    }
    return -1;
  }
  bool has(uint32_t flags, uint32_t mask) const { return (state.flags & mask) == flags; }
  /// Homed, and none of these, within three seconds.
  bool is_ready(uint32_t bad = kDeviceLost) {
    return tick_until(3000, [&] { return has(kDeviceHomed, kDeviceHomed | bad); }) > 0;
  }

  DeviceConfig config;
  std::unique_ptr<Device> device;
  DeviceState state{};
  int64_t next_ns = now_ns();
};

struct Desk : Host {
  explicit Desk(const EmulatedFalconOptions& options)
      : falcon(options), testbed(umockdev_testbed_new()), usb(testbed.get(), falcon, 2) {}
  ~Desk() { device.reset(); }  // while its node is there

  std::array<int, 3> motors() {
    const std::lock_guard guard(usb.lock());
    return falcon.motors();
  }
  bool pushes() { return motors() != std::array<int, 3>{}; }
  void lie(EmulatorFault how) {
    const std::lock_guard guard(usb.lock());
    falcon.lie(how);
  }
  /// Opens it and presses.
  void push() {
    open();
    REQUIRE(tick_until(3000, [&] { return pushes(); }) > 0);
  }

  EmulatedFalcon falcon;
  std::unique_ptr<UMockdevTestbed, Unref> testbed;
  UmockUsb usb;
};

std::string image_file(const TemporaryFolder& folder) {
  std::string path = folder.path() + "/image.bin";
  std::ofstream(path, std::ios::binary) << std::string(7914, 'f');
  return path;
}

}  // namespace

TEST_CASE("falcon over usbfs: found, driven, and let go of", "[device-io]") {
  if (!is_below_umockdev()) return;
  Desk desk(pressing());
  const auto plugged = list_plugged();
  REQUIRE(plugged.size() == 1);
  CHECK(plugged[0].serial == "EMU0001");
  CHECK(plugged[0].port == "1-2");
  desk.open();
  REQUIRE(desk.is_ready());
  CHECK_THAT(desk.device->description(), Contains("homed"));
  REQUIRE(desk.tick_until(3000, [&] { return desk.pushes(); }) > 0);
  desk.device->stop();
  desk.tick_until(50, [&] { return false; });
  desk.device->stop();
  usleep(20'000);
  CHECK_FALSE(desk.pushes());
}

TEST_CASE("falcon over usbfs: an image is sent, again after an echo that differs", "[device-io]") {
  if (!is_below_umockdev()) return;
  const TemporaryFolder folder;
  EmulatedFalconOptions options = pressing();
  options.has_firmware = false;
  options.wrong_echoes = GENERATE(0, 1);
  Desk desk(options);
  CHECK_THROWS_WITH(desk.open(), Contains("no firmware"));
  assign(desk.config.falcon.firmware, image_file(folder));
  desk.open();
  CHECK(desk.is_ready());
}

TEST_CASE("falcon over usbfs: unplugged in flight it is lost, and back at another node it is ready",
          "[device-io]") {
  if (!is_below_umockdev()) return;
  Desk desk(pressing());
  desk.push();
  desk.usb.unplug();
  // counted in ticks of the driver, at most one a millisecond: a machine that stands still has
  // fewer
  const int found = desk.tick_until(2000, [&] { return desk.has(kDeviceLost, kDeviceLost); });
  CAPTURE(found);
  REQUIRE(found > 0);
  CHECK(found <= 21);
  CHECK_THROWS_WITH(open_node(desk.config), Contains("no falcon is plugged in"));
  desk.device.reset();
  desk.usb.plug(3);
  desk.open();
  CHECK(desk.is_ready());
}

TEST_CASE("falcon over usbfs: what is said is recorded, and played to its driver again",
          "[device-io]") {
  if (!is_below_umockdev()) return;
  ByteRecord record;
  Desk desk(pressing());
  desk.push();
  REQUIRE(record.listen_to(*desk.device));
  // the exchange begins anew, and has learnt after half a second that it may challenge the firmware
  int since = 0;
  REQUIRE(desk.tick_until(5000, [&] {
    constexpr uint32_t kBad = kDeviceLost | kDeviceStale;
    return ++since > 600 &&
           desk.has(kDeviceFresh | kDeviceHomed, kDeviceFresh | kDeviceHomed | kBad);
  }) > 0);
  const DeviceState last = desk.state;
  desk.device.reset();
  const ReplayedPackets replayed = replay_falcon(record.pieces());
  REQUIRE(replayed.samples.size() > 30);
  CHECK(replayed.mismatches == 0);
  const uint32_t flags = replayed.samples.back().flags;
  CHECK((flags & (kDeviceHomed | kDeviceLost | kDeviceStale | kDeviceNoisy)) == kDeviceHomed);
  CHECK(std::ranges::any_of(replayed.samples, [&](const DeviceState& sample) {
    return norm(sample.X_BH.p - last.X_BH.p) < 2e-4;
  }));
}

TEST_CASE("falcon over usbfs: half packets, lost bytes and a stale queue end in sense or in zero",
          "[device-io]") {
  if (!is_below_umockdev()) return;
  Desk desk(pressing());
  desk.push();
  const auto fault =
      GENERATE(EmulatorFault::kHalves, EmulatorFault::kLoses, EmulatorFault::kOldFirst);
  desk.lie(fault);
  const int stale = desk.tick_until(300, [&] { return desk.has(kDeviceStale, kDeviceStale); });
  if (fault == EmulatorFault::kOldFirst) CHECK(stale > 0);
  CHECK(std::isfinite(desk.state.X_BH.p.z));
  desk.lie(EmulatorFault::kHealthy);
  CHECK(desk.is_ready(kDeviceLost | kDeviceStale));
}

namespace {

/// Stops a process between two of its ioctls: umockdev reads the memory of whoever calls, and would
/// wait for ever for one that stands in the midst of a call, or crash on one that dies there.
/// `node`: the same device, opened by this process.
void stop_between_calls(pid_t pid, int node) {
  for (;;) {
    kill(pid, SIGSTOP);
    REQUIRE(waitpid(pid, nullptr, WUNTRACED) == pid);
    // answered in turn with what the other has still asked: the second only if that came to its end
    std::future<void> answered = std::async(std::launch::async, [node] {
      usbdevfs_getdriver driver{};
      for (int i = 0; i < 2; ++i) ioctl(node, USBDEVFS_GETDRIVER, &driver);
    });
    if (answered.wait_for(std::chrono::milliseconds(100)) == std::future_status::ready) return;
    kill(pid, SIGCONT);
    answered.wait();
  }
}

// umockdev does not know duplicates, so that hapticd's descriptor is another one of the same node;
// that the claim survives the servo is tested in a virtual machine (tests/usb)
void check_release_of(int how) {
  int go[2], pipe_ends[2];
  REQUIRE(pipe(go) == 0);
  REQUIRE(pipe(pipe_ends) == 0);
  // before umockdev has threads, whose locks a child would find held
  const pid_t servo = fork();
  if (servo == 0) {
    std::array<char, 256> folder{};
    if (read(go[0], folder.data(), folder.size() - 1) <= 0) _exit(1);
    setenv("UMOCKDEV_DIR", folder.data(), 1);
    Host host;
    host.open();
    const DeviceRelease release = host.device->release();
    if (write(pipe_ends[1], &release, sizeof release) != sizeof release) _exit(1);
    host.tick_until(100'000, [] { return false; });
    _exit(0);
  }
  Desk desk(pressing());
  const FileDescriptor kept = open_node(desk.config);
  const std::string folder = std::getenv("UMOCKDEV_DIR");
  REQUIRE(write(go[1], folder.data(), folder.size()) > 0);
  DeviceRelease release{};
  REQUIRE(read(pipe_ends[0], &release, sizeof release) == sizeof release);
  const int64_t until_ns = now_ns() + 5000 * kMs;
  while (!desk.pushes() && now_ns() < until_ns) usleep(1000);
  REQUIRE(desk.pushes());
  stop_between_calls(servo, kept.get());
  if (how == SIGKILL) {
    kill(servo, SIGKILL);
    REQUIRE(waitpid(servo, nullptr, 0) == servo);
  }
  CHECK(send_release(kept.get(), release));
  CHECK_FALSE(desk.pushes());
  const UsbfsAccount account = desk.usb.account();
  CHECK(account.releases == 1);
  CHECK(account.bulks == 1);
  CHECK(account.in_flight_then == 0);
  if (how != SIGKILL) {
    kill(servo, SIGKILL);
    REQUIRE(waitpid(servo, nullptr, 0) == servo);
  }
  for (const int fd : {go[0], go[1], pipe_ends[0], pipe_ends[1]}) close(fd);
}

}  // namespace

// one case each, so that each forks in a process in which umockdev has no threads yet
TEST_CASE("falcon over usbfs: of a servo that is stopped, hapticd cancels what is in flight",
          "[device-io]") {
  if (is_below_umockdev()) check_release_of(SIGSTOP);
}

TEST_CASE("falcon over usbfs: of a servo that is dead, hapticd cancels what is in flight",
          "[device-io]") {
  if (is_below_umockdev()) check_release_of(SIGKILL);
}
