// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes of hid_to_pc_message and pc_to_hid_message of the firmware (WoodenHaptics/
// woody-experimental, mbed-code/WoodenHapticsHID/main.cpp): four little-endian shorts each way on a
// Cortex-M3; and any other bytes.
#include "device-io/hidarm/report.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "device-io/hidarm/hid_exchange.h"
#include "tests/support/torture_scale.h"

using namespace haptic;

TEST_CASE("hid arm: an input report is three counts and a counter", "[device-io]") {
  const std::vector<uint8_t> bytes{0x34, 0x12, 0xff, 0xff, 0x00, 0x80, 0xfe, 0xff};
  MotorSample sample;
  uint16_t counter = 0;
  REQUIRE(decode_hid_arm(bytes, sample, counter));
  CHECK(sample.counts == std::array<int16_t, 3>{0x1234, -1, -32768});
  CHECK(counter == 65534);
}

TEST_CASE("hid arm: an output report is number 0, three currents and a spare word", "[device-io]") {
  CHECK(encode_hid_arm({3000, -3000, -1}) ==
        HidArmCommand{0, 0xb8, 0x0b, 0x48, 0xf4, 0xff, 0xff, 0, 0});
  CHECK(encode_hid_arm({}) == HidArmCommand{});
}

TEST_CASE("hid arm: reports of another length are refused", "[device-io]") {
  const size_t size = GENERATE(0u, 1u, 4u, 7u, 9u, 64u);
  MotorSample sample;
  uint16_t counter = 7;
  CHECK_FALSE(decode_hid_arm(std::vector<uint8_t>(size, 0xff), sample, counter));
  CHECK(counter == 7);
}

TEST_CASE("hid arm: fuzz: whatever is reported, samples are those of whole reports in order",
          "[device-io][fuzz]") {
  // 10⁷ reports: HAPTIC_TORTURE_SCALE=500
  std::minstd_rand random(11);
  MotorMailbox mailbox;
  HidExchange exchange(mailbox);
  const auto rounds = static_cast<int>(test::sweep(20'000));
  uint16_t counter = 0;
  uint64_t refused = 0;
  for (int i = 0; i < rounds; ++i) {
    std::vector<uint8_t> report(random() % 4 == 0 ? random() % 65 : 8);
    for (uint8_t& byte : report) byte = static_cast<uint8_t>(random() >> 8);
    if (report.size() == 8 && random() % 2 == 0) {
      ++counter;
      report[6] = static_cast<uint8_t>(counter % 256);
      report[7] = static_cast<uint8_t>(counter / 256);
    }
    refused += report.size() != 8;
    exchange.hear(report, 1'000'000LL * (i + 1));
    const auto newest = mailbox.newest();
    if (newest) REQUIRE(newest->heard_ns <= 1'000'000LL * (i + 1));
    if (newest) REQUIRE(newest->asked_ns <= newest->heard_ns);
  }
  CHECK(exchange.rejected() == refused);
  CHECK(exchange.heard() + exchange.rejected() <= static_cast<uint64_t>(rounds));
  // and an honest arm is believed again after 256 reports in order
  for (int i = 1; i <= 700; ++i) {
    ++counter;
    exchange.hear(std::vector<uint8_t>{1, 0, 2, 0, 3, 0, static_cast<uint8_t>(counter % 256),
                                       static_cast<uint8_t>(counter / 256)},
                  1'000'000LL * (rounds + 200 + i));
  }
  CHECK_FALSE(mailbox.is_stale());
  CHECK(mailbox.newest()->counts == std::array<int16_t, 3>{1, 2, 3});
}
