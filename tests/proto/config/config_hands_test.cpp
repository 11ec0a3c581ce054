// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for [[hand]] in a session file: proto/config/config, proto/config/hand_config.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/config/hand_config.h"

using namespace haptic;

namespace {

const std::string kSession = "[session]\nname = \"t\"\n";
const std::string kDevice = "[device]\nkind = \"simulated-hand\"\n";
const std::string kObject =
    "[[object]]\nname = \"cup\"\nprimitive = \"sphere\"\nsize = \"80 mm\"\n";

std::string hand(const std::string& name, const std::string& more = "") {
  return "[[hand]]\nname = \"" + name + "\"\n" + more;
}

std::string mistake_in(const std::string& text) {
  try {
    parse_hands(text, "t.toml");
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("config: without [[hand]] a session has one hand, without a name") {
  const auto hands = parse_hands(kSession + kDevice + kObject, "t.toml");
  REQUIRE(hands.size() == 1);
  CHECK(hands[0].n_hands == 1);
  CHECK(hands[0].hand == 0);
  CHECK(view(hands[0].hand_names[0]).empty());
  CHECK(name_of_hand(hands[0], 0) == "0");
}

TEST_CASE("config: a hand has tables of its own and the session's where it has none") {
  const auto hands = parse_hands(
      kSession + kDevice + "[coupling]\nstiffness = \"500 N/m\"\ndamping = \"1 N·s/m\"\n" +
          kObject + hand("left") +
          hand("right",
               "renderer = \"penalty3\"\n[hand.device]\nkind = \"falcon\"\n"
               "[hand.coupling]\nstiffness = \"900 N/m\"\n[hand.servo]\nrate = \"4 kHz\"\n"),
      "t.toml");
  REQUIRE(hands.size() == 2);
  for (uint32_t k = 0; k < 2; ++k) {
    CHECK(hands[k].hand == k);
    CHECK(hands[k].n_hands == 2);
    CHECK(view(hands[k].hand_names[0]) == "left");
    CHECK(view(hands[k].hand_names[1]) == "right");
    CHECK(hands[k].n_objects == 1);
  }
  CHECK(row_of(hands[0].device.kind).name == "simulated-hand");
  CHECK(row_of(hands[1].device.kind).name == "falcon");
  CHECK(hands[0].coupling.translational_stiffness == 500);
  CHECK(hands[0].coupling.translational_damping == 1);
  // a table of its own stands for all of the session's
  CHECK(hands[1].coupling.translational_stiffness == 900);
  CHECK(hands[1].coupling.translational_damping == 0);
  CHECK(hands[0].servo_rate == 1000);
  CHECK(hands[1].servo_rate == 4000);
  CHECK(hands[0].renderer != hands[1].renderer);
  // motors that are there begin disarmed, those of the other hand do not
  CHECK(hands[0].safety.armed_at_start == 1);
  CHECK(hands[1].safety.armed_at_start == 0);
}

TEST_CASE("config: hands are found by name and by number") {
  const SessionConfig config =
      parse_config(kSession + kDevice + kObject + hand("left") + hand("right"), "t.toml");
  CHECK(hand_named(config, "left") == 0u);
  CHECK(hand_named(config, "right") == 1u);
  CHECK(hand_named(config, "1") == 1u);
  CHECK_FALSE(hand_named(config, "2"));
  CHECK_FALSE(hand_named(config, "middle"));
  CHECK_FALSE(hand_named(config, ""));
  CHECK(names_of_all_hands(config) == "left, right");
}

TEST_CASE("config: mistakes in a hand are told with their line") {
  const std::string text = kSession + kDevice + kObject;
  CHECK(has(mistake_in(text + hand("left", "colour = 1\n")), "t.toml:11:"));
  CHECK(has(mistake_in(text + hand("left", "[hand.coupling]\nstiffness = 5\n")), "t.toml:12:"));
  CHECK(has(mistake_in(text + hand("left", "[hand.coupling]\nstifness = \"5 N/m\"\n")), "stif"));
  CHECK(has(mistake_in(text + hand("left") + hand("left")), "is used twice ('left')"));
  for (const char* name : {"", "0", "all", "a b", "l\x1b"}) {
    CAPTURE(name);
    CHECK(has(mistake_in(text + hand(name)), name == std::string("l\x1b") ? "t.toml" : "name"));
  }
  CHECK(has(mistake_in(text + "[[hand]]\n"), "has no 'name'"));
  CHECK(has(mistake_in(text + hand("a") + hand("b") + hand("c") + hand("d") + hand("e")),
            "one [[hand]] too many"));
  CHECK(has(mistake_in(kSession + kObject + hand("left")), "no 'device'"));
  CHECK(has(mistake_in(text + "[hand]\nname = \"left\"\n"), "[[hand]]"));
  // a mistake of the second hand alone
  CHECK(has(mistake_in(text + hand("left") + hand("right", "[hand.map]\nmotion_scale = 0\n")),
            "motion_scale"));
}

TEST_CASE("config: two hands on one device are refused") {
  const auto on = [](const std::string& name, const std::string& device) {
    return hand(name, "[hand.device]\n" + device);
  };
  const auto serial = [](const std::string& path) {
    return "kind = \"woodenhaptics\"\n[hand.device.serial]\npath = \"" + path + "\"\n";
  };
  const std::string text = kSession + kObject;
  const std::string falcon = "kind = \"falcon\"\n";
  CHECK(mistake_in(text + on("l", falcon) + on("r", falcon)) ==
        "t.toml: hands 'l' and 'r' may be on the same device; give each its serial or its port in "
        "[hand.device.usb] (hapt devices lists them)");
  const auto usb = [&](const std::string& number) {
    return falcon + "[hand.device.usb]\nserial = \"" + number + "\"\n";
  };
  CHECK(has(mistake_in(text + on("l", usb("A")) + on("r", usb("A"))), "the same device"));
  CHECK(has(mistake_in(text + on("l", usb("A")) + on("r", falcon)), "the same device"));
  CHECK(mistake_in(text + on("l", usb("A")) + on("r", usb("B"))).empty());
  CHECK(has(mistake_in(text + on("l", serial("/dev/a")) + on("r", serial("/dev/a"))),
            "its own path"));
  CHECK(mistake_in(text + on("l", serial("/dev/a")) + on("r", serial("/dev/b"))).empty());
  CHECK(mistake_in(text + on("l", falcon) + on("r", serial("/dev/b"))).empty());
  CHECK(mistake_in(text + kDevice + hand("l") + hand("r")).empty());
}
