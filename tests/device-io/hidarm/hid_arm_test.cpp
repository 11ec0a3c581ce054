// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a WoodenHaptics over HID: its packets and its states. tests/device-io/driver tests
// what all drivers share.
#include "device-io/hidarm/hid_arm.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "proto/math/units.h"
#include "tests/support/driver/hid_arm_bench.h"
#include "tests/support/driver/rows.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("hid arm: reports that are lost are counted", "[device-io]") {
  Wall w(driver_row("hid arm"));
  CHECK(w.bench->oddities() == 0);
  w.bench->lie(Lie::kLoses);
  w.run(2000);
  CHECK(w.bench->oddities() > 100);
}

TEST_CASE("hid arm: a host that is gone lets go within 0.5 s", "[device-io]") {
  Wall w(driver_row("hid arm"));
  w.bench->cut();
  auto& arm = w.as<HidArmBench>().emulated();
  UsbBytes packet;
  arm.give(0x81, 64, packet, w.t_ns + 400 * kMs);
  CHECK(arm.is_enabled());
  arm.give(0x81, 64, packet, w.t_ns + 600 * kMs);
  CHECK_FALSE(arm.is_enabled());
}

TEST_CASE("hid arm: counts go on past 16 bits", "[device-io]") {
  auto mailbox = std::make_shared<MotorMailbox>();
  DeviceConfig config;
  config.hid_arm.counts_per_turn = 200'000;  // a turn of A is 3.2 million counts
  ThreeMotorDevice device(hid_arm(config.hid_arm), {}, config, mailbox);
  DeviceState state;
  double before = 0;
  for (int i = 0; i <= 20; ++i) {
    // A turns by 10,000 counts each tick: −2π/320, its sine grows up to 20 of them
    MotorSample sample;
    sample.counts[0] = static_cast<int16_t>(static_cast<uint16_t>(10'000 * i));
    sample.number = static_cast<uint8_t>(i);
    sample.asked_ns = sample.heard_ns = (i + 1) * kMs;
    mailbox->put(sample);
    device.read({(i + 1) * kMs, (i + 1) * kMs}, state);
    if (i > 0) CHECK(state.X_BH.p.y < before);
    before = state.X_BH.p.y;
  }
  // radius of the forearm at home: 0.245 m
  CHECK(state.X_BH.p.y == Approx(-0.245 * std::sin(2 * M_PI * 200'000 / 3.2e6)).epsilon(1e-6));
}
