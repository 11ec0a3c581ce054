// SPDX-License-Identifier: GPL-3.0-or-later
// The keys of [device.pantograph].
#include <catch2/catch.hpp>
#include <numbers>

#include "proto/config/devices.h"
#include "tests/support/config_text.h"
#include "tests/support/data.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::string haply_with(const std::string& keys) {
  return scene_with("kind = \"simulated-hand\"\n",
                    "kind = \"haply-2dof\"\n[device.serial]\npath = \"/dev/ttyACM7\"\n"
                    "[device.pantograph]\n" +
                        keys);
}

}  // namespace

TEST_CASE("haply config: its keys are read with their units", "[device-io]") {
  const DeviceConfig device =
      parse_config(haply_with("proximal = \"7 cm\"\ndistal = \"90 mm\"\nbase = \"0 mm\"\n"
                              "counts_per_turn = 10752\noffset_1 = \"241 deg\"\n"
                              "offset_2 = \"-61 deg\"\nsign_1 = -1\nport_1 = 2\nreduction = 1.5\n"
                              "max_torque = \"100 mN·m\"\nvelocity_cutoff = \"60 Hz\"\n"),
                   "x.toml")
          .device;
  CHECK(device.kind == DeviceKind::kHaply);
  const PantographConfig& arm = device.pantograph;
  CHECK(arm.proximal == Approx(0.07));
  CHECK(arm.distal == Approx(0.09));
  CHECK(arm.base == 0);
  CHECK(arm.counts_per_turn == 10752);
  CHECK(arm.offset_1 == Approx(241 * std::numbers::pi / 180));
  CHECK(arm.offset_2 == Approx(-61 * std::numbers::pi / 180));
  CHECK(arm.sign_1 == -1);
  CHECK(arm.sign_2 == 1);
  CHECK(arm.port_1 == 2);
  CHECK(arm.reduction == 1.5);
  CHECK(arm.max_torque == Approx(0.1));
  CHECK(arm.velocity_cutoff == 60);
}

TEST_CASE("haply config: what is no pantograph is refused", "[device-io]") {
  for (const char* key :
       {"sign_1 = 0.5\n", "sign_2 = 2\n", "port_1 = 3\n", "port_1 = 0\n", "proximal = \"0 mm\"\n",
        "base = \"-1 mm\"\n", "counts_per_turn = 100000\n", "max_torque = \"1 N·m\"\n",
        "max_torque = \"0 N·m\"\n", "reduction = 0\n", "link = \"1 mm\"\n"}) {
    const std::string error = error_of(haply_with(key));
    CAPTURE(key, error);
    CHECK(error.find("x.toml:8:") == 0);
    CHECK(error.find('\n') == std::string::npos);
  }
}

TEST_CASE("haply config: its session file is sound", "[device-io]") {
  const SessionConfig config = load_config(from_source("configs/haply.toml"));
  CHECK(config.device.kind == DeviceKind::kHaply);
  // the middle of the workspace is the origin of the scene
  const Vec3 middle = config.device.workspace_centre_B;
  CHECK(norm(config.map.X_WB * middle) < 1e-9);
}
