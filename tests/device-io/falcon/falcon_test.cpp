// SPDX-License-Identifier: GPL-3.0-or-later
// The Falcon's driver: its homing, its challenges, the lateness of its chip. tests/device-io/driver
// tests what all drivers share.
#include "device-io/falcon/falcon.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "proto/math/units.h"
#include "tests/support/driver/falcon_bench.h"
#include "tests/support/driver/rows.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A Falcon that a typical hand presses for a while.
Wall pressed(EmulatedFalconOptions options = {}) {
  const DriverRow& row = driver_row("falcon");
  options.hand = pressing(row, "typical", row.wall.depth);
  Wall w(row, std::make_unique<FalconBench>(options));
  w.run(1500);
  return w;
}

}  // namespace

TEST_CASE("falcon: without homing there is no force, and with it there is", "[device-io]") {
  const bool is_homed = GENERATE(false, true);
  Wall w = pressed({.is_homed = is_homed});
  CHECK(w.has(kDeviceHomed) == is_homed);
  CHECK((w.bench->effort() > 0) == is_homed);
}

TEST_CASE("falcon: a firmware that ignores challenges is not challenged", "[device-io]") {
  const bool ignores = GENERATE(false, true);
  Wall w = pressed({.shows_homing = ignores});
  CHECK(w.as<FalconBench>().exchange().is_challenged() != ignores);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.is_working());
}

TEST_CASE("falcon: a single answer too many is no lie, and old ones are counted", "[device-io]") {
  Wall w = pressed();
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  w.as<FalconBench>().emulated().take(2, zero.data(), zero.size(), w.bench->t_ns());
  w.run(205);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.is_working());
  w.bench->lie(Lie::kOldFirst);
  CHECK(w.ticks_until(kDeviceStale, 60) > 0);
  CHECK(w.bench->oddities() > 0);
}

TEST_CASE("falcon: an honest one behind a busy machine is believed, however late it is",
          "[device-io]") {
  Wall w = pressed();
  // most answers later than a question is asked again, and hapticd's zeros among them
  const int most_ms = GENERATE(8, 15, 40);
  std::minstd_rand random(7);
  auto& late = w.as<FalconBench>().late;
  late = [&] { return random() % 10 < 3 ? 0 : random() % most_ms * kMs; };
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  for (int i = 0; i < 60; ++i) {
    w.run(20 + static_cast<int>(random() % 100));
    if (random() % 2 == 1) w.bench->tell(zero);
  }
  CAPTURE(most_ms);
  CHECK((w.seen & kDoubt) == 0);
  // and once the machine is quiet, a lie is found
  late = [] { return 0; };
  w.run(500);
  CHECK((w.state.flags & (kDeviceFresh | kDoubt)) == kDeviceFresh);
  REQUIRE(w.is_working());
  w.bench->lie(Lie::kFrozen);
  w.run(110);
  CHECK(w.bench->effort() == 0);
}

TEST_CASE("falcon: counts that wrap are followed, and those of no place are not homed",
          "[device-io]") {
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice driver(falcon_arm({}), falcon_flags(), {}, mailbox);
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
