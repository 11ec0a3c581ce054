// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of the Falcon and an emulated one, on virtual time.
#include "device-io/falcon/falcon.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "device-io/hand/impedance.h"
#include "tests/support/near.h"
#include "tests/support/usb/falcon_bench.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kMs = 1'000'000;
constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;

/// A hand of this kind that aims `press` below the middle, with a tremor of 0.1 mm.
EmulatedFalconOptions pressing(const char* hand, double press) {
  EmulatedFalconOptions options;
  options.hand.mass = 0.25;
  options.hand.damping = 1;
  options.hand.coulomb_friction = 0.3;
  put_into_hand(*find_hand(hand), options.hand);
  options.hand.intent.centre_B = {0, 0, -press};
  options.hand.intent.direction_B = {0, 0, 1};
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.stroke_angle = 0;
  options.hand.intent.tremor_amplitude = 1e-4;
  return options;
}

/// A wall at z = 0 under the hand.
struct Wall {
  FalconBench bench;
  double stiffness = 500;
  DeviceState state{};
  int64_t t_ns;
  uint32_t seen = 0;  // flags so far

  explicit Wall(const EmulatedFalconOptions& options) : bench(options), t_ns(bench.t_ns()) {}

  void step() {
    t_ns += kMs;
    bench.read({t_ns, t_ns}, state);
    seen |= state.flags;
    const bool closed = (state.flags & (kDeviceLost | kDoubt)) != 0;
    bench.write({{0, 0, closed ? 0 : -stiffness * std::min(0.0, state.X_BH.p.z)}, {}});
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
  int ticks_until(uint32_t flag, int most) {
    for (int i = 0; i < most; ++i) {
      step();
      if ((state.flags & flag) != 0) return i + 1;
    }
    return -1;
  }
  int largest_word() const {
    int largest = 0;
    for (const int w : bench_motors()) largest = std::max(largest, std::abs(w));
    return largest;
  }
  const std::array<int, 3>& bench_motors() const {
    return const_cast<FalconBench&>(bench).emulated().motors();
  }
};

void check_found(Wall& w, uint32_t flag, int within) {
  const int found = w.ticks_until(flag, 3 * within);
  CAPTURE(found);
  CHECK(found > 0);
  CHECK(found <= within);
  w.run(10);
  CHECK(w.largest_word() == 0);
}

}  // namespace

TEST_CASE("falcon: the pose is that of the hand, to a count", "[device-io]") {
  EmulatedFalconOptions options = pressing("typical", 0);
  options.hand.intent.centre_B = {0.02, -0.015, 0.01};
  options.hand.coulomb_friction = 0;
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(1500);
  CHECK_THAT(w.state.X_BH.p, IsNear(w.bench.emulated().plant().p_B, 60e-6));
  CHECK((w.state.flags & (kDeviceHomed | kDeviceLost)) == kDeviceHomed);
  CHECK(w.bench.exchange().surplus() == 0);
  CHECK(w.bench.exchange().is_challenged());
  // the chip's millisecond: nearly one exchange a tick
  CHECK(w.bench.exchange().answered() > 1200);
}

TEST_CASE("falcon: the force at the handle is the one commanded", "[device-io]") {
  Wall w(pressing("stiff-arm", 0.005));
  w.run(2000);
  const double commanded = -500 * w.state.X_BH.p.z;
  REQUIRE(commanded > 1);
  // a word is 0.1 mN·m, a count of delay 25 mN
  CHECK_THAT(w.bench.emulated().force_B(), IsNear({0, 0, commanded}, 0.15));
}

TEST_CASE("falcon: five hands on a wall of 500 N/m through its bytes: no limit cycle",
          "[device-io]") {
  const char* const hand = GENERATE("none", "light-grip", "typical", "firm", "stiff-arm");
  EmulatedFalconOptions options = pressing(hand, 0.01);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(2000);
  double least = 1e9, most = -1e9;
  for (int i = 0; i < 1000; ++i) {
    w.step();
    least = std::min(least, w.bench.emulated().force_B().z);
    most = std::max(most, w.bench.emulated().force_B().z);
  }
  CAPTURE(hand, least, most);
  // a count at the handle is up to 50 µm, 25 mN at this stiffness
  CHECK(most - least < 0.06);
}

TEST_CASE("falcon: a wall far beyond the chip's delay is a limit cycle, so that it would be seen",
          "[device-io]") {
  EmulatedFalconOptions options = pressing("light-grip", 0.01);
  options.hand.intent.tremor_amplitude = 0;
  options.hand.coulomb_friction = 0;
  Wall w(options);
  w.stiffness = 6000;
  w.run(2000);
  double least = 1e9, most = -1e9;
  for (int i = 0; i < 1000; ++i) {
    w.step();
    least = std::min(least, w.bench.emulated().force_B().z);
    most = std::max(most, w.bench.emulated().force_B().z);
  }
  CHECK(most - least > 1);
}

TEST_CASE("falcon: without homing there is no force, and with it there is", "[device-io]") {
  EmulatedFalconOptions options = pressing("typical", 0.02);
  options.is_homed = false;
  Wall w(options);
  w.run(500);
  CHECK((w.state.flags & kDeviceHomed) == 0);
  CHECK(w.largest_word() == 0);
}

TEST_CASE("falcon: lying device: frozen, it is found and gets zero", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  REQUIRE(w.largest_word() > 200);
  REQUIRE((w.seen & kDoubt) == 0);
  w.bench.emulated().lie(FalconFault::kFrozen);
  check_found(w, kDeviceStale, 100);
  w.run(200);
  CHECK(w.largest_word() == 0);
  w.bench.emulated().lie(FalconFault::kHealthy);
  w.run(1000);
  CHECK((w.state.flags & kDoubt) == 0);
  CHECK(w.largest_word() > 200);
}

TEST_CASE("falcon: lying device: answers that are old but valid are found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(FalconFault::kOldFirst);
  check_found(w, kDeviceStale, 60);
  CHECK(w.bench.exchange().surplus() > 0);
}

TEST_CASE("falcon: lying device: answers from a queue are found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  REQUIRE((w.seen & kDoubt) == 0);
  w.bench.emulated().lie(FalconFault::kDelayed);
  check_found(w, kDeviceStale, 100);
}

TEST_CASE("falcon: a firmware that ignores challenges is not challenged", "[device-io]") {
  EmulatedFalconOptions options = pressing("typical", 0.02);
  options.shows_homing = true;
  Wall w(options);
  w.run(1500);
  CHECK_FALSE(w.bench.exchange().is_challenged());
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.largest_word() > 200);
}

TEST_CASE("falcon: lying device: noise on one encoder is found", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(FalconFault::kNoise);
  check_found(w, kDeviceNoisy, 100);
}

TEST_CASE("falcon: lying device: a flipped encoder drives nothing beyond the limits",
          "[device-io]") {
  // it is honest to the protocol; the hand's motion is wrong, and the limits hold all the same
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(FalconFault::kFlipped);
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    w.step();
    most = std::max(most, norm(w.bench.emulated().force_B()));
  }
  CHECK(std::isfinite(norm(w.state.X_BH.p)));
  CHECK(most <= kFalconMaxForce * 1.01);
}

TEST_CASE("falcon: a single answer too many, and those to hapticd's zero, are no lie",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  const int others = GENERATE(1, 4);
  for (int i = 0; i < others; ++i) {
    if (others > 1) w.bench.begin_anew();
    w.bench.emulated().take(2, zero.data(), zero.size(), w.bench.t_ns());
    w.run(5);
  }
  w.run(200);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.largest_word() > 200);
}

TEST_CASE("falcon: an honest one behind a busy machine is believed, however late it is",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  // most answers later than a question is asked again, and hapticd's zeros among them
  const int most_ms = GENERATE(8, 15, 40);
  std::minstd_rand random(7);
  w.bench.late = [&] { return random() % 10 < 3 ? 0 : random() % most_ms * kMs; };
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  for (int i = 0; i < 60; ++i) {
    w.run(20 + static_cast<int>(random() % 100));
    if (random() % 2 == 0) continue;
    w.bench.begin_anew();
    w.bench.emulated().take(2, zero.data(), zero.size(), w.bench.t_ns());
  }
  CAPTURE(most_ms);
  CHECK((w.seen & kDoubt) == 0);
  // and once the machine is quiet, a lie is found
  w.bench.late = [] { return 0; };
  w.run(500);
  CHECK((w.state.flags & (kDeviceFresh | kDoubt)) == kDeviceFresh);
  REQUIRE(w.largest_word() > 200);
  w.bench.emulated().lie(FalconFault::kFrozen);
  w.run(110);
  CHECK(w.largest_word() == 0);
}

TEST_CASE("falcon: silent, it is lost within 20 ms and gets zero when it answers again",
          "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().lie(FalconFault::kSilent);
  const int found = w.ticks_until(kDeviceLost, 100);
  CHECK(found > 0);
  CHECK(found <= 22);
  w.run(200);
  CHECK(w.largest_word() == 0);
  w.bench.emulated().lie(FalconFault::kHealthy);
  w.run(300);
  CHECK((w.state.flags & kDeviceLost) == 0);
}

TEST_CASE("falcon: half packets and lost bytes cost samples, not sense", "[device-io]") {
  const auto fault = GENERATE(FalconFault::kHalves, FalconFault::kLoses);
  EmulatedFalconOptions options = pressing("typical", 0.02);
  options.hand.intent.tremor_amplitude = 0;
  Wall w(options);
  w.run(1100);
  const double settled = w.state.X_BH.p.z;
  w.bench.emulated().lie(fault);
  double farthest = 0;
  for (int i = 0; i < 2000; ++i) {
    w.step();
    farthest = std::max(farthest, std::fabs(w.state.X_BH.p.z - settled));
  }
  CAPTURE(farthest);
  CHECK(farthest < 0.002);
  CHECK((w.state.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed);
}

TEST_CASE("falcon: a servo that stands still lets go within 12 ms", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  REQUIRE(w.largest_word() > 200);
  w.bench.pass(w.t_ns + 12 * kMs);
  CHECK(w.largest_word() == 0);
}

TEST_CASE("falcon: cut power is a device that is lost, then not homed", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.emulated().cut_power();
  w.run(50);
  CHECK((w.state.flags & kDeviceLost) != 0);
}

TEST_CASE("falcon: counts that wrap are followed, and those of no place are not homed",
          "[device-io]") {
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice driver(falcon_arm({}), {}, mailbox);
  DeviceState state;
  mailbox->put({{30'000, 30'000, 30'000}, 0x70, 0, kMs, kMs});
  driver.read({kMs, kMs}, state);
  CHECK((state.flags & kDeviceHomed) == 0);
  driver.write({{0, 0, 5}, {}});
  CHECK(mailbox->command_at(kMs)->motors == std::array<int16_t, 3>{});
  mailbox->put({{-200, -200, -200}, 0x74, 1, 2 * kMs, 2 * kMs});
  CHECK(driver.read({2 * kMs, 2 * kMs}, state));
  CHECK((state.flags & kDeviceHomed) != 0);
  CHECK(state.buttons == 4);
  CHECK_THAT(state.X_BH.p, IsNear({0, 0, 0}, 50e-6));
  CHECK_FALSE(driver.read({3 * kMs, 3 * kMs}, state));
}

TEST_CASE("falcon: a firmware brought up anew is not homed, whichever question is a challenge",
          "[device-io]") {
  const auto answer = [](FalconExchange& exchange, uint8_t flags, int64_t t_ns) {
    UsbBytes packet{0x01, 0x60};
    const std::string text = "<AAAAAAAAAAAA" + std::string(1, static_cast<char>(0x41 + flags));
    packet.insert(packet.end(), text.begin(), text.end());
    packet.insert(packet.end(), {'A', '>'});
    exchange.ask(t_ns);
    exchange.hear(packet, t_ns + kMs);
  };
  for (int homed = 1; homed < 40; ++homed) {
    MotorMailbox mailbox;
    FalconExchange exchange(mailbox);
    int64_t t_ns = kMs;
    for (int n = 0; n < homed; ++n, t_ns += 2 * kMs) {
      // before any answer homing is asked for; a challenge takes it back
      answer(exchange, 0x70, t_ns);
    }
    exchange.restart();
    answer(exchange, 0, t_ns);
    CAPTURE(homed);
    CHECK((mailbox.newest()->flags & kFalconLegs) == 0);
  }
}

TEST_CASE("falcon: a wrench that is not finite is no force", "[device-io]") {
  Wall w(pressing("typical", 0.02));
  w.run(1100);
  w.bench.write({{std::nan(""), 0, 0}, {}});
  w.bench.pass(w.t_ns + 3 * kMs);
  CHECK(w.largest_word() == 0);
}

TEST_CASE("falcon: its zero is a bulk packet without force", "[device-io]") {
  const DeviceRelease release = falcon_arm({}).release;
  CHECK(release.by == static_cast<uint32_t>(ReleaseBy::kUsbBulk));
  CHECK(release.endpoint == 2);
  CHECK(std::string(release.bytes.data(), release.size) == "<AAAAAAAAAAAABA>");
}
