// SPDX-License-Identifier: GPL-3.0-or-later
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "proto/config/config.h"
#include "tests/support/config_text.h"

namespace haptic {
namespace {

using test::error_of;
using test::kScene;

const std::string kBody =
    "[object.body]\n"
    "mass = \"1 kg\"\n";

SessionConfig parse(const std::string& joints) {
  return parse_config(kScene + kBody + joints, "scene.toml");
}

}  // namespace

TEST_CASE("config: a hinge with all that acts along it", "[config][joints]") {
  const SessionConfig config = parse(
      "[[joint]]\n"
      "name = \"door\"\n"
      "kind = \"hinge\"\n"
      "object = \"block\"\n"
      "at = [\"1 cm\", \"2 cm\", \"3 cm\"]\n"
      "axis = [0, 3, 4]\n"
      "lower = \"-10 deg\"\n"
      "upper = \"90 deg\"\n"
      "stiffness = \"0.5 N·m/rad\"\n"
      "rest = \"45 deg\"\n"
      "damping = \"2 mN·m·s/rad\"\n"
      "friction = \"10 mN·m\"\n"
      "detents = [[\"0 deg\", \"0 N·m\"], [\"18 deg\", \"-0.3 N·m\"]]\n");
  REQUIRE(config.n_joints == 1);
  const JointConfig& joint = config.joints[0];
  CHECK(view(joint.name) == "door");
  CHECK(joint.kind == JointKind::kHinge);
  CHECK(joint.object == 0);
  CHECK(joint.to == kToWorld);
  CHECK(joint.at_W == Vec3{0.01, 0.02, 0.03});
  CHECK(joint.axis_W == Vec3{0, 0.6, 0.8});
  CHECK(joint.lower == Approx(-std::numbers::pi / 18));
  CHECK(joint.upper == Approx(std::numbers::pi / 2));
  CHECK(joint.stiffness == 0.5);
  CHECK(joint.rest == Approx(std::numbers::pi / 4));
  CHECK(joint.damping == Approx(2e-3));
  CHECK(joint.friction == Approx(0.01));
  REQUIRE(joint.n_detents == 2);
  CHECK(joint.detents[1].position == Approx(std::numbers::pi / 10));
  CHECK(joint.detents[1].load == -0.3);
}

TEST_CASE("config: a slider has lengths and forces, a curve its points", "[config][joints]") {
  const SessionConfig config = parse(
      "[[joint]]\n"
      "kind = \"slider\"\n"
      "object = \"block\"\n"
      "axis = [1, 0, 0]\n"
      "lower = \"-5 mm\"\n"
      "friction = \"0.5 N\"\n"
      "[[joint]]\n"
      "kind = \"curve\"\n"
      "object = \"block\"\n"
      "points = [[\"0 mm\", \"10 mm\", \"0 mm\"], [\"20 mm\", \"30 mm\", \"0 mm\"]]\n"
      "stiffness = \"20 N/m\"\n");
  REQUIRE(config.n_joints == 2);
  CHECK(config.joints[0].lower == -0.005);
  CHECK(!is_stop(config.joints[0].upper));
  CHECK(config.joints[0].friction == 0.5);
  CHECK(view(config.joints[0].name) == "joint 1");
  REQUIRE(config.joints[1].n_points == 2);
  CHECK(config.joints[1].points_W[1] == Vec3{0.02, 0.03, 0});
}

TEST_CASE("config: a joint that cannot be is refused with place and mend", "[config][joints]") {
  const auto error = [](const std::string& text) { return error_of(kScene + kBody + text); };
  const std::string hinge = "[[joint]]\nkind = \"hinge\"\nobject = \"block\"\n";
  const std::string axis = "axis = [0, 0, 1]\n";
  CHECK_THAT(error("[[joint]]\nkind = \"hing\"\n"), Catch::Contains("did you mean 'hinge'"));
  CHECK_THAT(error("[[joint]]\nkind = \"hinge\"\n"), Catch::Contains("has no 'object'"));
  CHECK_THAT(error("[[joint]]\nkind = \"ball\"\nobject = \"blok\"\n"),
             Catch::Contains("did you mean 'block'"));
  CHECK_THAT(error(hinge), Catch::Contains("has no 'axis'"));
  CHECK_THAT(error(hinge + axis + "to = \"block\"\n"), Catch::Contains("is the object itself"));
  CHECK_THAT(error(hinge + axis + "lower = \"5 deg\"\n"), Catch::Contains("'lower'"));
  CHECK_THAT(error(hinge + axis + "lower = \"-5 mm\"\n"), Catch::Contains("is a length, not"));
  CHECK_THAT(error(hinge + axis + "rest = \"5 deg\"\n"), Catch::Contains("stiffness"));
  CHECK_THAT(error(hinge + axis + "detents = [[\"0 deg\", \"0 N·m\"]]\n"),
             Catch::Contains("single point"));
  CHECK_THAT(error(hinge + axis + "detents = [[\"5 deg\", \"0 N·m\"], [\"5 deg\", \"1 N·m\"]]\n"),
             Catch::Contains("do not ascend at row 2"));
  CHECK_THAT(error(hinge + axis + "detents = [[\"5 deg\"]]\n"),
             Catch::Contains("must be 2 values"));
  CHECK_THAT(error("[[joint]]\nkind = \"curve\"\nobject = \"block\"\n"),
             Catch::Contains("has no 'points'"));
  CHECK_THAT(error("[[joint]]\nkind = \"curve\"\nobject = \"block\"\n"
                   "points = [[\"0 mm\", \"0 mm\", \"0 mm\"]]\n"),
             Catch::Contains("same point twice"));
  CHECK_THAT(error("[[joint]]\nkind = \"ball\"\nobject = \"block\"\nfriction = \"1 N·m\"\n"),
             Catch::Contains("unknown key 'friction'"));
  CHECK_THAT(error_of(kScene + hinge + axis), Catch::Contains("has no mass"));
}

}  // namespace haptic
