// SPDX-License-Identifier: GPL-3.0-or-later
// The driver on a real node (a pseudo-terminal), with the test acting as the device.
#include "device-io/woodenhaptics/kinematics.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <thread>

#include "device-io/emulator/firmware.h"
#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"
#include "proto/os/serial_port.h"
#include "tests/support/near.h"
#include "tests/support/pty_line.h"
#include "tests/support/tip.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::PtyLine;
using haptic::test::tip_at;

namespace {

constexpr int64_t kStart = 1'000'000 * kMs;  // of the ticks

DeviceConfig config_for(const PtyLine& line) {
  DeviceConfig config;
  config.kind = DeviceKind::kWoodenHaptics;
  assign(config.serial.path, line.name());
  return config;
}

/// Opens the driver while the test answers its first question.
std::unique_ptr<Device> open(const PtyLine& line, const DeviceConfig& config,
                             const std::string& answer) {
  std::thread device([&] {
    line.hear();
    line.say(answer);
  });
  struct Join {
    std::thread& thread;
    ~Join() { thread.join(); }
  } const join{device};
  return open_device(config);
}

std::string answer_of(const MotorCounts& n, int error = 0) {
  return "[3," + std::to_string(n[0]) + "," + std::to_string(n[1]) + "," + std::to_string(n[2]) +
         ",0,0,0," + std::to_string(error) + "]\n";
}

/// A driver that has asked for its first sample, its line, and a clock controlled by the test.
struct Bench {
  PtyLine line;
  std::unique_ptr<Device> device;
  int64_t t_ns = kStart;
  DeviceState state{};

  explicit Bench(DeviceConfig config = {}, const std::string& greeting = answer_of({0, 0, 0})) {
    config.kind = DeviceKind::kWoodenHaptics;
    assign(config.serial.path, line.name());
    device = open(line, config, greeting);
    // no question yet: the pose of the greeting, held
    CHECK_FALSE(read());
    CHECK(has(kDeviceHeld));
    CHECK_FALSE(has(kDeviceFresh));
    CHECK_THAT(state.X_BH.p, IsNear({0.025, 0, 0.205}, 1e-12));
    device->write({});
  }
  bool read(int64_t later_ns = kMs) {
    t_ns += later_ns;
    return device->read({t_ns, t_ns}, state);
  }
  /// A tick in which the device answers the line of the previous tick.
  bool tick(const Vec3& force_B, const MotorCounts& counts) {
    line.say(answer_of(counts));
    const bool fresh = read();
    device->write({force_B, {}});
    return fresh;
  }
  /// A tick of a device that does not answer.
  void miss(const Vec3& force_B) {
    read();
    device->write({force_B, {}});
  }
  bool has(uint32_t flag) const { return (state.flags & flag) != 0; }
};

std::string line_for(const MotorCounts& counts, const Vec3& force_B) {
  const Arm& arm = woodenhaptics_arm();
  MotorEfforts amperes;
  REQUIRE(arm.efforts(arm.angles(counts), {}, {force_B, {}}, amperes));
  Milliamperes whole;
  for (size_t i = 0; i < whole.size(); ++i) {
    whole[i] = static_cast<int32_t>(std::lround(1000 * amperes[i]));
  }
  return std::string(encode_currents(whole).view());
}

}  // namespace

TEST_CASE("woodenhaptics driver: encoder counts become a pose of the tick that asked",
          "[device-io]") {
  Bench b;
  CHECK(b.has(kDeviceHomed));
  const int64_t asked_ns = b.t_ns;
  CHECK(b.tick({}, {500, -1000, 2000}));
  CHECK(b.has(kDeviceFresh));
  CHECK_FALSE(b.has(kDeviceHeld | kDeviceLost));
  CHECK(b.state.t_ns == asked_ns);
  CHECK(b.state.X_BH.p == tip_at({500, -1000, 2000}));
  CHECK(b.state.X_BH.q == Quat{});
  // no answer: the same state, held
  const DeviceState before = b.state;
  CHECK_FALSE(b.read());
  CHECK(b.has(kDeviceHeld));
  CHECK_FALSE(b.has(kDeviceFresh));
  CHECK(b.state.X_BH.p == before.X_BH.p);
  CHECK(b.state.t_ns == before.t_ns);
}

TEST_CASE("woodenhaptics driver: a force becomes the currents of the pose it was felt at",
          "[device-io]") {
  Bench b;
  const MotorCounts counts{500, -1000, 2000};
  b.line.hear();
  const Vec3 force_B{0.5, -1, 2};
  b.tick(force_B, counts);
  CHECK(b.line.hear() == line_for(counts, force_B));
  CHECK_FALSE(b.has(kDeviceSaturated));
}

TEST_CASE("woodenhaptics driver: a force that is not a number is sent as zero", "[device-io]") {
  Bench b;
  b.line.hear();
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  b.tick({0, bad, 0}, {0, 0, 0});
  CHECK(b.line.hear() == kZeroCommand);
  b.tick({}, {0, 0, 0});
  CHECK(b.has(kDeviceSaturated));
}

TEST_CASE("woodenhaptics driver: one line is under way at a time, a lost one is asked again",
          "[device-io]") {
  Bench b;
  CHECK(b.line.hear() == kZeroCommand);
  for (int i = 0; i < 4; ++i) b.miss({0, 0, 1});
  CHECK(b.line.hear(0).empty());
  b.miss({0, 0, 1});
  CHECK_FALSE(b.line.hear(100).empty());
}

TEST_CASE("woodenhaptics driver: an answer with an error holds old counts and is not a sample",
          "[device-io]") {
  Bench b;
  b.tick({}, {10, 20, 30});
  const Vec3 before_B = b.state.X_BH.p;
  const int error = GENERATE(8, 256, 512, 1024);
  b.line.say(answer_of({900, 900, 900}, error));
  CHECK_FALSE(b.read());
  CHECK(b.has(kDeviceHeld));
  CHECK(b.state.X_BH.p == before_B);
  // but it is an answer: the next line is sent at once
  b.line.hear();
  b.device->write({});
  CHECK_FALSE(b.line.hear(100).empty());
}

TEST_CASE("woodenhaptics driver: noise, torn lines and another model are no samples",
          "[device-io]") {
  const std::string text = GENERATE("garbage\n", "[3,1,2", "[3,nan,0,0,0,0,0,0]\n",
                                    "[1,5,5,5,0,0,0,0]\n", "[3,2000000,0,0,0,0,0,0]\n");
  CAPTURE(text);
  Bench b;
  b.line.say(text);
  CHECK_FALSE(b.read());
  CHECK_THAT(b.state.X_BH.p, IsNear({0.025, 0, 0.205}, 1e-12));
  b.device->write({});
  // a torn answer does not spoil the next one
  CHECK(b.tick({}, {1, 2, 3}));
  CHECK(b.state.X_BH.p == tip_at({1, 2, 3}));
}

TEST_CASE("woodenhaptics driver: a flood of bytes costs one read a bounded amount", "[device-io]") {
  Bench b;
  b.line.say(std::string(3000, 'x'));
  b.line.say(answer_of({7, 7, 7}));
  // 1 KiB per tick: the third read reaches its end
  int ticks = 0;
  while (!b.read(kMs / 10)) {
    ++ticks;
    REQUIRE(ticks < 10);
  }
  CHECK(ticks >= 2);
}

TEST_CASE("woodenhaptics driver: a device that falls silent is lost after 20 ms and gets zero",
          "[device-io]") {
  Bench b;
  b.tick({0, 0, 2}, {0, 0, 0});
  b.line.hear();
  int64_t silent = 0;
  for (; silent < 100 && !b.has(kDeviceLost); ++silent) b.miss({0, 0, 2});
  CHECK(silent == 21);
  // the zero is under way, and every command from now on is one
  const std::string said = b.line.hear(50);
  REQUIRE(said.size() >= kZeroCommand.size());
  CHECK(said.substr(said.size() - kZeroCommand.size()) == kZeroCommand);
  for (int i = 0; i < 60; ++i) b.miss({0, 0, 2});
  CHECK(b.line.hear() == kZeroCommand);
  // it answers again: the jump in between is not a velocity
  CHECK_FALSE(b.tick({0, 0, 2}, {3000, 0, 0}));
  CHECK(b.tick({}, {3000, 0, 0}));
  CHECK_FALSE(b.has(kDeviceLost));
  CHECK(b.state.V_BH.v == Vec3{});
}

TEST_CASE("woodenhaptics driver: after a silence zero is confirmed before any force is sent",
          "[device-io]") {
  Bench b;
  b.tick({0, 0, 2}, {0, 0, 0});
  for (int i = 0; i < 40; ++i) b.miss({0, 0, 2});
  REQUIRE(b.has(kDeviceLost));
  b.line.hear();
  // the first answer was under way when the device fell silent: the lines since then are queued,
  // and the firmware drops queued lines
  CHECK_FALSE(b.tick({0, 0, 2}, {10, 0, 0}));
  CHECK(b.has(kDeviceLost));
  CHECK(b.line.hear() == kZeroCommand);
  b.line.say(answer_of({10, 0, 0}, 8));
  CHECK_FALSE(b.read());
  b.device->write({{0, 0, 2}, {}});
  CHECK(b.line.hear() == kZeroCommand);
  // that line was obeyed
  CHECK(b.tick({0, 0, 2}, {10, 0, 0}));
  CHECK_FALSE(b.has(kDeviceLost));
  CHECK(b.line.hear() != kZeroCommand);
}

TEST_CASE("woodenhaptics driver: a silent device is asked ever more rarely", "[device-io]") {
  Bench b;
  b.line.hear();
  size_t lines = 0;
  for (int i = 0; i < 5000; ++i) {
    b.miss({0, 0, 2});
    const std::string said = b.line.hear(0);
    lines += static_cast<size_t>(std::count(said.begin(), said.end(), '\n'));
  }
  // 5, 10, 20, 40, 80 ms apart, then 100 ms
  CHECK(lines >= 45);
  CHECK(lines <= 55);
}

TEST_CASE("woodenhaptics driver: after a pause of the loop the force does not jump back",
          "[device-io]") {
  Bench b;
  b.tick({0, 0, 2}, {0, 0, 0});
  b.line.hear();
  b.line.say(answer_of({0, 0, 0}));
  const int64_t pause_ms = GENERATE(80, 120);
  b.read(pause_ms * kMs);
  b.device->write({{0, 0, 2}, {}});
  CHECK(b.has(kDeviceFresh));
  // the firmware releases the motors after 100 ms
  CHECK(b.has(kDeviceLost) == (pause_ms > 100));
  CHECK((b.line.hear() == kZeroCommand) == (pause_ms > 100));
  // and the answer to the next line confirms the zero
  CHECK(b.tick({}, {0, 0, 0}) == (pause_ms < 100));
  b.tick({}, {0, 0, 0});
  CHECK(b.has(kDeviceFresh));
  CHECK_FALSE(b.has(kDeviceLost));
}

TEST_CASE("woodenhaptics driver: unplugged, it is lost for good and nothing fails", "[device-io]") {
  Bench b;
  b.tick({0, 0, 2}, {10, 20, 30});
  const Vec3 before_B = b.state.X_BH.p;
  b.line.unplug();
  for (int i = 0; i < 5; ++i) {
    CHECK_FALSE(b.read());
    CHECK(b.has(kDeviceLost));
    CHECK(b.has(kDeviceHeld));
    CHECK(b.state.X_BH.p == before_B);
    b.device->write({{0, 0, 2}, {}});
  }
  b.device->stop();
}

TEST_CASE("woodenhaptics driver: the velocity follows a ramp", "[device-io]") {
  Bench b;
  for (int n = 0; n <= 200; ++n) {
    // an honest device answers an invalid line as such, before the question
    const std::string asked = b.line.hear();
    const std::string echo =
        asked.rfind("[]", 0) == 0 ? answer_of({0, 0, 5 * n - 5}, 512) : std::string();
    b.line.say(echo + answer_of({0, 0, 5 * n}));
    REQUIRE(b.read());
    b.device->write({});
  }
  // 5 counts of the forearm per millisecond, at the pose half a tick earlier
  const Vec3 per_count_B = tip_at({0, 0, 1000}) - tip_at({0, 0, 999});
  CHECK_THAT(b.state.V_BH.v, IsNear(5 / 1e-3 * per_count_B, 2e-3));
}

TEST_CASE("woodenhaptics driver: stop sends zero until it is confirmed, and takes no time",
          "[device-io]") {
  Bench b;
  b.tick({0, 0, 2}, {0, 0, 0});
  b.line.hear();
  // no answers, several times, for 40 ms
  const int64_t begin_ns = now_ns();
  b.device->stop();
  CHECK(now_ns() - begin_ns < 500 * kMs);
  std::string said = b.line.hear();
  CHECK(said.size() >= kZeroCommand.size());
  CHECK(said.size() <= 8 * kZeroCommand.size());
  while (said.starts_with(kZeroCommand)) said.erase(0, kZeroCommand.size());
  CHECK(said.empty());
  // a device that answers is not sent more
  std::string told;
  std::thread device([&] {
    told = b.line.hear();
    b.line.say(answer_of({0, 0, 0}));
  });
  b.device->stop();
  device.join();
  told += b.line.hear(50);
  CHECK(told.rfind(kZeroCommand, 0) == 0);
  CHECK(told.size() <= 4 * kZeroCommand.size());
}

TEST_CASE("woodenhaptics driver: stop is obeyed by a firmware that was held up meanwhile",
          "[device-io]") {
  const int64_t held_up_ms = GENERATE(0, 3, 6, 8, 12, 16);
  CAPTURE(held_up_ms);
  Bench b;
  b.line.hear();
  EmulatedDevice firmware({}, now_ns());
  b.tick({0, 0, 2}, {0, 0, 0});  // its line waits, and is replaced by the zero
  std::atomic<bool> ending{false};
  std::thread device([&] {
    DeadlineClock clock(kMs / 4);
    const int64_t awake_ns = now_ns() + held_up_ms * kMs;
    while (!ending) {
      clock.wait();
      if (now_ns() < awake_ns) continue;
      const std::string bytes = b.line.hear(0);
      firmware.receive(bytes);
      firmware.turn(now_ns());
      if (!firmware.answer().empty()) b.line.pass(firmware.answer());
    }
  });
  b.device->stop();
  ending = true;
  device.join();
  CHECK(firmware.record().watchdog == 0);
  CHECK(firmware.record().commands > 0);
  CHECK(firmware.record().currents == Milliamperes{});
}

TEST_CASE("woodenhaptics driver: another process lets go of the device with a copy of two things",
          "[device-io]") {
  Bench b;
  const DeviceRelease release = b.device->release();
  const FileDescriptor copy(open(b.line.name().c_str(), O_RDWR | O_NOCTTY));
  b.line.hear(0);
  b.device.reset();
  const auto size = static_cast<ssize_t>(release.size);
  REQUIRE(write(copy.get(), release.bytes.data(), release.size) == size);
  CHECK(b.line.hear() == kZeroCommand);
}

TEST_CASE("woodenhaptics driver: it drives a node that is open already", "[device-io]") {
  PtyLine line;
  DeviceConfig config = config_for(line);
  FileDescriptor node = open_serial_port(line.name());
  assign(config.serial.path, "/nowhere");
  std::thread device([&] {
    line.hear();
    line.say(answer_of({0, 0, 0}));
  });
  const auto driver = open_device(config, std::move(node));
  device.join();
  CHECK(driver->caps().max_force == 5);
  CHECK_FALSE(driver->caps().simulated);
}

TEST_CASE("woodenhaptics driver: a firmware that waits for its button is not homed",
          "[device-io]") {
  // the first encoder follows a sine, the second repeats the first current
  Bench b({}, answer_of({8000, 0, 0}));
  CHECK(b.device->description().find("NOT HOMED") != std::string::npos);
  CHECK_FALSE(b.has(kDeviceHomed));
  for (int n = 1; n < 50; ++n) {
    const std::string asked = b.line.hear();
    const int current = std::stoi(asked.substr(1));
    REQUIRE(current <= 7);
    REQUIRE(asked.find(",0,0]") != std::string::npos);
    b.line.say(answer_of({8000 + n, current, 0}));
    REQUIRE_FALSE(b.read());
    REQUIRE_FALSE(b.has(kDeviceHomed));
    REQUIRE_FALSE(b.has(kDeviceLost));
    REQUIRE_THAT(b.state.X_BH.p, IsNear({0.025, 0, 0.205}, 1e-12));
    b.device->write({{0, 0, 3}, {}});
  }
  CHECK(b.tick({}, {2, -1, 3}));
  CHECK(b.has(kDeviceHomed));
}

TEST_CASE("woodenhaptics driver: what does not answer as one is refused in one line",
          "[device-io]") {
  PtyLine line;
  CHECK_THROWS_WITH(open(line, config_for(line), "[1,0,0,0,0,0,0,0]\n"),
                    Catch::Contains("answers as model 1") && Catch::Contains(line.name()));
  CHECK_THROWS_WITH(open(line, config_for(line), "hello\n"), Catch::Contains("no answer within 2"));
  DeviceConfig config = config_for(line);
  assign(config.serial.path, "/dev/not-there");
  CHECK_THROWS_WITH(open_device(config),
                    Catch::Contains("/dev/not-there: cannot be opened") && Catch::Contains("plug"));
  assign(config.serial.path, "/dev/null");
  CHECK_THROWS_WITH(open_device(config), Catch::Contains("is no serial node"));
}

TEST_CASE("woodenhaptics driver: two programs do not drive one device", "[device-io]") {
  PtyLine line;
  const FileDescriptor first = open_serial_port(line.name());
  CHECK_THROWS_WITH(open_serial_port(line.name()), Catch::Contains("another program drives it"));
}
