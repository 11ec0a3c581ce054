// SPDX-License-Identifier: GPL-3.0-or-later
// Reports recorded on the bus (AndunHH/spacemouse, SpaceNavigator.md and SpaceMouse Wireless), and
// layouts as PySpaceMouse describes them: channel, first and second byte of each axis.
#include "device-io/spacemouse/report.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

using Bytes = std::vector<uint8_t>;
using Axes = std::array<int16_t, 6>;

}  // namespace

TEST_CASE("spacemouse: reports recorded from a SpaceNavigator", "[device-io]") {
  SpaceMouseInput input;
  // a rotation about its second axis
  CHECK(take_report(Bytes{0x02, 0x00, 0x00, 0xe2, 0xff, 0x00, 0x00}, input) ==
        SpaceMouseReport::kAxes);
  CHECK(input.axes == Axes{0, 0, 0, 0, -30, 0});
  // translations say nothing about rotations
  CHECK(take_report(Bytes{0x01, 0x5e, 0x01, 0xa2, 0xfe, 0x07, 0x00}, input) ==
        SpaceMouseReport::kAxes);
  CHECK(input.axes == Axes{350, -350, 7, 0, -30, 0});
  CHECK(take_report(Bytes{0x03, 0x01, 0x00}, input) == SpaceMouseReport::kButtons);
  CHECK(input.buttons == 1);
  CHECK(take_report(Bytes{0x03, 0x03, 0x00}, input) == SpaceMouseReport::kButtons);
  CHECK(input.buttons == 3);
  CHECK(take_report(Bytes{0x03, 0x00, 0x00}, input) == SpaceMouseReport::kButtons);
  CHECK(input.buttons == 0);
  CHECK(input.axes == Axes{350, -350, 7, 0, -30, 0});
}

TEST_CASE("spacemouse: thirteen bytes hold all six axes, whatever the model", "[device-io]") {
  SpaceMouseInput input;
  CHECK(take_report(Bytes{1, 0, 0, 0, 0, 0, 0, 0, 0, 0xe2, 0xff, 0, 0}, input) ==
        SpaceMouseReport::kAxes);
  CHECK(input.axes == Axes{0, 0, 0, 0, -30, 0});
  CHECK(take_report(Bytes{1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 1}, input) ==
        SpaceMouseReport::kAxes);
  CHECK(input.axes == Axes{1, 2, 3, 4, 5, 262});
}

TEST_CASE("spacemouse: the buttons of the Pro family are numbered by their bits", "[device-io]") {
  SpaceMouseInput input;
  // MENU is bit 0, button 1 bit 12, SHIFT bit 24
  CHECK(take_report(Bytes{3, 0x01, 0x10, 0x00, 0x01, 0, 0}, input) == SpaceMouseReport::kButtons);
  CHECK(input.buttons == (1u | 1u << 12 | 1u << 24));
}

TEST_CASE("spacemouse: a battery is no motion, other reports are none at all", "[device-io]") {
  SpaceMouseInput input;
  input.axes = {1, 2, 3, 4, 5, 6};
  CHECK(take_report(Bytes{0x17, 0x64, 0x00}, input) == SpaceMouseReport::kOther);
  for (const Bytes& bad :
       {Bytes{}, Bytes{1}, Bytes{1, 0, 0, 0}, Bytes(8, 1), Bytes(14, 1), Bytes(13, 2), Bytes{3},
        Bytes{3, 1}, Bytes(14, 3), Bytes{0, 1, 2}, Bytes(64, 0xff)}) {
    CHECK(take_report(bad, input) == SpaceMouseReport::kInvalid);
  }
  CHECK(input.axes == Axes{1, 2, 3, 4, 5, 6});
  CHECK(input.buttons == 0);
}

TEST_CASE("spacemouse: fuzz: any report changes what it may, and nothing else",
          "[device-io][fuzz]") {
  // 10⁷ reports: HAPTIC_TORTURE_SCALE=500
  std::minstd_rand random(3);
  SpaceMouseInput input;
  const auto rounds = static_cast<int>(test::sweep(20'000));
  for (int i = 0; i < rounds; ++i) {
    Bytes report(random() % 3 == 0 ? random() % 65 : random() % 2 == 0 ? 7 : 13);
    for (uint8_t& byte : report) byte = static_cast<uint8_t>(random() >> 8);
    if (!report.empty() && random() % 4 != 0) report[0] = static_cast<uint8_t>(random() % 5);
    const SpaceMouseInput before = input;
    const SpaceMouseReport kind = take_report(report, input);
    if (kind != SpaceMouseReport::kAxes) REQUIRE(input.axes == before.axes);
    if (kind != SpaceMouseReport::kButtons) REQUIRE(input.buttons == before.buttons);
    if (kind == SpaceMouseReport::kAxes) REQUIRE((report.size() == 7 || report.size() == 13));
  }
}
