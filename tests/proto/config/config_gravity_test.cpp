// SPDX-License-Identifier: GPL-3.0-or-later
// The keys of [device.gravity].
#include "proto/config/devices.h"
#include "tests/support/config_text.h"

namespace haptic {
namespace {

using test::Bad;

std::string arm_with(const std::string& keys) {
  return test::scene_with(
      "kind = \"simulated-hand\"\n",
      "kind = \"woodenhaptics\"\n[device.serial]\npath = \"/dev/ttyACM7\"\n" + keys);
}

}  // namespace

TEST_CASE("config: the masses of an arm, by the names of its links", "[config]") {
  const GravityConfig gravity =
      parse_config(arm_with("[device.gravity]\ndown = [0, 0, -2]\n"
                            "[device.gravity.handle]\nmass = \"50 g\"\n"
                            "[device.gravity.forearm]\nmass = \"-0.11 kg\"\n"
                            "centre = [\"91 mm\", \"0 mm\", \"-5 mm\"]\n"),
                   "x.toml")
          .device.gravity;
  CHECK(gravity.down_B == Vec3{0, 0, -1});
  CHECK(gravity.handle.mass == 0.05);
  CHECK(gravity.links[0].mass == 0);
  CHECK(gravity.links[1].mass == -0.11);
  CHECK(gravity.links[1].centre == Vec3{0.091, 0, -0.005});
}

TEST_CASE("config: mistakes in the masses of an arm name their place", "[config]") {
  Bad{arm_with("[device.gravity.crank]\nmass = \"1 g\"\n"), "7:17",
      "unknown key 'crank' in [device.gravity]"}
      .check();
  Bad{arm_with("[device.gravity.handle]\ncentre = [\"1 mm\", \"0 mm\", \"0 mm\"]\n"), "7:1",
      "[device.gravity.handle] has no 'mass'; add for example mass = \"120 g\""}
      .check();
  Bad{arm_with("[device.gravity.handle]\nmass = \"50 kg\"\n"), "8:8", "'mass'"}.check();
  Bad{test::scene_with("[coupling]", "[device.gravity.handle]\nmass = \"50 g\"\n[coupling]"), "",
      "'gravity' needs motors that hold up an arm"}
      .check();
}

}  // namespace haptic
