// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/config/config.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "proto/config/config_warnings.h"
#include "proto/config/renderer_needs.h"
#include "proto/wire/renderer.h"
#include "tests/support/config_text.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

using test::Bad;
using test::error_of;
using test::kBox;
using test::kScene;
using test::object_with;
using test::scene_with;
using test::session_with;

/// The dimensions of an object that must be of this kind.
template <typename Kind>
Kind part_with(const std::string& keys) {
  return std::get<Kind>(object_with(keys).primitive);
}

}  // namespace

TEST_CASE("config: a tool and the voxels reach their fields, and follow the size") {
  const SessionConfig config =
      session_with("[coupling]\n",
                   "[contact.voxel]\nsize = \"0.5 mm\"\noffset_layers = 1\nfield = false\n"
                   "open_as_sheet = true\nstiffness = \"2 kN/m\"\nbraking = \"0.5 N·s/m\"\n"
                   "budget = 5000\n"
                   "[tool]\nprimitive = \"bolt\"\ndiameter = \"20 mm\"\npitch = \"2.5 mm\"\n"
                   "depth = \"1.4 mm\"\nlength = \"40 mm\"\naround = 48\nmass = \"80 g\"\n"
                   "inertia = [\"1e-5 kg·m²\", \"100 g·cm²\", \"5e-6 kgm2\"]\n[coupling]\n");
  const VoxelConfig& voxel = config.voxel;
  CHECK(voxel.size == 0.5e-3);
  CHECK(voxel.offset_layers == 1);
  CHECK(voxel.field == 0);
  CHECK(voxel.open_as_sheet == 1);
  // one layer, and invalid values
  CHECK(voxel.band == (1 + kBandVoxels) * voxel.size);
  CHECK(voxel.point_spacing == voxel.size);
  CHECK(voxel.stiffness == 2000);
  CHECK(voxel.braking == 0.5);
  CHECK(voxel.budget == 5000);
  const ToolConfig& tool = config.tool;
  CHECK(mesh_name(tool) == "primitive:bolt");
  const auto& bolt = std::get<primitive::Bolt>(tool.primitive);
  CHECK(bolt.pitch == 2.5e-3);
  CHECK(bolt.grid.around == 48);
  CHECK(bolt.grid.along == 256);
  CHECK(bolt.length == 0.04);
  CHECK(tool.mass == 0.08);
  CHECK(tool.density == 0);
  CHECK(std::abs(tool.inertia.y - 1e-5) <= test::tol(1e-20));
  CHECK(tool.inertia.z == 5e-6);
  const SessionConfig dense =
      session_with("", "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\ndensity = \"2 g/cm³\"\n");
  CHECK(dense.tool.density == 2000);
  CHECK_FALSE(has_mesh(parse_config(kScene, "x.toml").tool));
  CHECK(parse_config(kScene, "x.toml").voxel.band == (2 + kBandVoxels) * VoxelConfig{}.size);
}

TEST_CASE("config: how a tool is moved reaches its fields") {
  const std::string tool = "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\n";
  const auto turning = [](std::string scene) {
    const std::string stiffness = "stiffness = \"800 N/m\"\n";
    return scene.insert(scene.find(stiffness), "rotational_stiffness = \"1 N·m/rad\"\n");
  };
  const SessionConfig config = parse_config(
      turning(scene_with("name = \"test\"\n", "name = \"test\"\nrenderer = \"voxel\"\n")) + tool +
          "[proxy]\nsolver = \"penalty-dynamics\"\nintegrator = \"semi-implicit\"\n"
          "contact_stiffness = \"3 kN/m\"\ncontact_damping = \"0.5 N·s/m\"\n"
          "sharing = \"none\"\n"
          "[contact.voxel]\nbraking_along = \"normal\"\n",
      "x.toml");
  CHECK(config.renderer == Renderer::kVoxel);
  CHECK(config.proxy.solver == SoftSolver::kPenaltyDynamics);
  CHECK(config.proxy.integrator == Integrator::kSemiImplicit);
  CHECK(config.proxy.contact_stiffness == 3000);
  CHECK(config.proxy.contact_damping == 0.5);
  CHECK(config.proxy.sharing == Sharing::kNone);
  CHECK(config.voxel.braking_along == Braking::kAlongNormal);
  CHECK(config.voxel.is_wanted == 1);
  const SessionConfig bounded =
      session_with("[coupling]\n", "[coupling]\nmax_force = \"4 N\"\nmax_torque = \"0.1 N·m\"\n");
  CHECK(bounded.coupling.max_force == 4);
  CHECK(bounded.coupling.max_torque == 0.1);
  CHECK_FALSE(bounded.proxy.solver);
  CHECK(bounded.voxel.is_wanted == 0);
}

TEST_CASE("config: a renderer of bodies without a tool is refused at its place") {
  const std::string renderer = GENERATE(as<std::string>(), "voxel", "direct6", "god-object6",
                                        "constrained6", "localized", "sensation");
  const std::string error = error_of(
      scene_with("name = \"test\"\n", "name = \"test\"\nrenderer = \"" + renderer + "\"\n"));
  CAPTURE(error);
  CHECK(error.rfind("x.toml:3:12: 'renderer' ", 0) == 0);
  CHECK(error.find("add [tool]") != std::string::npos);
}

TEST_CASE("config: a proxy without a spring for its turning is refused") {
  const std::string tool = "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\n";
  const auto scene = [&](const std::string& renderer) {
    return scene_with("name = \"test\"\n", "name = \"test\"\nrenderer = \"" + renderer + "\"\n") +
           tool;
  };
  const std::string error = error_of(scene("voxel"));
  CAPTURE(error);
  CHECK(error.rfind("x.toml:3:12: 'renderer' ", 0) == 0);
  CHECK(error.find("rotational_stiffness") != std::string::npos);
  CHECK(error_of(scene("direct6")).empty());
  CHECK(error_of(scene("voxel") + "[proxy]\nsolver = \"direct\"\n").empty());
}

TEST_CASE("config: how a rigid tool is led reaches its fields, and it always has springs") {
  const std::string tool = "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\n";
  const auto scene = [&](const std::string& renderer, bool turns) {
    std::string text =
        scene_with("name = \"test\"\n", "name = \"test\"\nrenderer = \"" + renderer + "\"\n");
    const std::string stiffness = "stiffness = \"800 N/m\"\n";
    if (turns) text.insert(text.find(stiffness), "rotational_stiffness = \"1 N·m/rad\"\n");
    return text + tool;
  };
  const std::string rigid =
      "[contact.rigid]\nk_s = 0.5\nmargin = \"2 µm\"\nmoves = 3\nsolver = \"lcp\"\n"
      "[proxy]\nsolver = \"direct\"\n";
  for (const auto& [name, renderer] : {std::pair{"god-object6", Renderer::kGodObject6},
                                       std::pair{"constrained6", Renderer::kConstrained6}}) {
    const SessionConfig config = parse_config(scene(name, true) + rigid, "x.toml");
    CHECK(config.renderer == renderer);
    CHECK(config.rigid.k_s == 0.5);
    CHECK(config.rigid.margin == 2e-6);
    CHECK(config.rigid.moves == 3);
    CHECK(config.rigid.solver == RigidSolver::kLcp);
    // a soft renderer's proxy may lack springs, a rigid one's always has them
    CHECK(has_springs(config.proxy, config.renderer));
    CHECK_FALSE(has_springs(config.proxy, Renderer::kVoxel));
    const std::string error = error_of(scene(name, false) + rigid);
    CAPTURE(name, error);
    CHECK(error.rfind("x.toml:3:12: 'renderer' ", 0) == 0);
    CHECK(error.find("rotational_stiffness") != std::string::npos);
  }
  const RigidConfig unsaid = parse_config(scene("god-object6", true), "x.toml").rigid;
  CHECK(unsaid.k_s == RigidConfig{}.k_s);
  CHECK(unsaid.margin == RigidConfig{}.margin);
  CHECK(unsaid.moves == RigidConfig{}.moves);
  CHECK(unsaid.solver == RigidSolver::kCoulomb);
}

TEST_CASE("config: a coupling too stiff for its device is warned of with the numbers") {
  const auto warned = [](const std::string& device, const std::string& coupling) {
    return config_warnings(
        session_with("[coupling]\nstiffness = \"800 N/m\"\n", device + "[coupling]\n" + coupling));
  };
  const std::string hand = "[device.hand]\ndamping = \"1 N·s/m\"\n";
  // 2 (b − b_c)/T = 2000 N/m without a damper of the coupling, 1200 with 0.4
  CHECK(warned(hand, "stiffness = \"1990 N/m\"\n").empty());
  const auto stiff = warned(hand, "stiffness = \"2 kN/m\"\n");
  REQUIRE(stiff.size() == 1);
  CHECK(stiff[0].find("2000 N/m") != std::string::npos);
  CHECK(stiff[0].find("two-port margin") != std::string::npos);
  CHECK(warned(hand, "stiffness = \"1100 N/m\"\ndamping = \"0.4 N·s/m\"\n").empty());
  CHECK(warned(hand, "stiffness = \"1200 N/m\"\ndamping = \"0.4 N·s/m\"\n").size() == 1);
  // a device has its own metres and newtons: s φ = 4
  CHECK(
      warned(hand, "stiffness = \"600 N/m\"\n[map]\nmotion_scale = 2\nforce_scale = 2\n").size() ==
      1);
  // without a proxy the hand feels the contacts directly
  const std::string direct = "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\n[proxy]\n";
  const auto felt = [&](const std::string& stiffness) {
    return config_warnings(
        parse_config(scene_with("name = \"test\"\n", "name = \"test\"\nrenderer = \"direct6\"\n") +
                         direct + "contact_stiffness = \"" + stiffness + "\"\n",
                     "x.toml"));
  };
  CHECK(felt("1900 N/m").empty());
  REQUIRE(felt("2 kN/m").size() == 1);
  CHECK(felt("2 kN/m")[0].find("contact_stiffness in [proxy]") != std::string::npos);
  // far more than the device holds is refused, unless it is forced
  const auto refused = [](const std::string& coupling) {
    return too_stiff(parse_config(scene_with("stiffness = \"800 N/m\"\n", coupling), "x.toml"));
  };
  CHECK(refused("stiffness = \"3999 N/m\"\n").empty());
  CHECK(refused("stiffness = \"4001 N/m\"\n").find("stiffness in [coupling] is 4001 N/m") == 0);
  CHECK(refused("stiffness = \"3001 N/m\"\ndamping = \"0.25 N·s/m\"\n").find("= 1500 N/m") !=
        std::string::npos);
  // rotation has its own margin if the device has torque and states its inertia
  const std::string torque =
      "max_torque = \"0.1 N·m\"\n[device.hand]\ninertia = \"1e-4 kg·m²\"\n"
      "rotational_damping = \"1e-3 N·m·s/rad\"\n";
  CHECK(warned(torque, "rotational_stiffness = \"1 N·m/rad\"\n").empty());
  const auto turning = warned(torque, "rotational_stiffness = \"3 N·m/rad\"\n");
  REQUIRE(turning.size() == 1);
  CHECK(turning[0].find("rotational_stiffness in [coupling] is 3 N·m/rad") != std::string::npos);
  // a handle that cannot turn feels none of it
  const auto still = warned("max_torque = \"0.1 N·m\"\n", "rotational_stiffness = \"1 N·m/rad\"\n");
  REQUIRE(still.size() == 1);
  CHECK(still[0].find("inertia in [device.hand]") != std::string::npos);
}

TEST_CASE("config: parts of machines are read with their dimensions") {
  const auto hole = part_with<primitive::Hole>(
      "primitive = \"hole\"\ndiameter = \"20 mm\"\nlength = \"40 mm\"\nclearance = \"0.2 mm\"\n"
      "block = \"60 mm\"\n");
  CHECK(hole.clearance == 0.2e-3);
  CHECK(hole.length == 0.04);
  CHECK(hole.block == 0.06);
  const auto gear = part_with<primitive::Gear>(
      "primitive = \"gear\"\nteeth = 21\nmodule = \"3 mm\"\nwidth = \"10 mm\"\nbore = \"10 mm\"\n"
      "along = 2\n");
  CHECK(gear.teeth == 21);
  CHECK(gear.grid.around == 24 * 21);
  CHECK(gear.grid.along == 2);
  CHECK(gear.backlash == 0.1e-3);
  const auto nut = part_with<primitive::Nut>(
      "primitive = \"nut\"\ndiameter = \"20 mm\"\npitch = \"2.5 mm\"\ndepth = \"1.4 mm\"\n"
      "clearance = \"0.05 mm\"\nheight = \"16 mm\"\nwidth = \"32 mm\"\n");
  CHECK(nut.height == 0.016);
  CHECK(nut.grid.along == 128);
  const auto peg =
      part_with<primitive::Peg>("primitive = \"peg\"\ndiameter = \"2 cm\"\nlength = \"4 cm\"\n");
  CHECK(peg.diameter == 0.02);
  CHECK(peg.length == 0.04);
}

TEST_CASE("config: molars, joints and dimpled balls are read with their dimensions") {
  const auto upper = part_with<primitive::UpperMolar>(
      "primitive = \"upper-molar\"\nwidth = \"33 mm\"\nclearance = \"0.2 mm\"\n");
  CHECK(upper.width == 33e-3);
  CHECK(upper.clearance == 0.2e-3);
  CHECK(upper.around == 264);
  const auto lower = part_with<primitive::LowerMolar>(
      "primitive = \"lower-molar\"\nwidth = \"33 mm\"\naround = 120\n");
  CHECK(lower.around == 120);
  CHECK(lower.width == 33e-3);
  const auto ball = part_with<primitive::JointBall>(
      "primitive = \"joint-ball\"\ndiameter = \"40 mm\"\nstem = \"16 mm\"\nlength = \"50 mm\"\n");
  CHECK(ball.stem == 0.016);
  CHECK(ball.length == 0.05);
  const auto socket = part_with<primitive::JointSocket>(
      "primitive = \"joint-socket\"\ndiameter = \"40 mm\"\nclearance = \"0.1 mm\"\n"
      "width = \"60 mm\"\nheight = \"30 mm\"\ncover = \"90 deg\"\n");
  CHECK(socket.cover == Approx(1.5707963267949));
  CHECK(socket.height == 0.03);
  const auto golf = part_with<primitive::DimpledBall>(
      "primitive = \"dimpled-ball\"\ndiameter = \"42.7 mm\"\ndepth = \"0.25 mm\"\n");
  CHECK(golf.along == 82);
  CHECK(golf.depth == 0.25e-3);
  const std::string frame = "length = \"18 cm\"\nwidth = \"24 mm\"\ndiameter = \"8 mm\"\n";
  const auto rail = part_with<primitive::FrameRail>("primitive = \"frame-rail\"\n" + frame +
                                                    "height = \"16 mm\"\nclearance = \"0.1 mm\"\n");
  CHECK(rail.length == 0.18);
  CHECK(rail.height == 16e-3);
  CHECK(rail.clearance == 0.1e-3);
  CHECK(rail.around == 48);
  const auto rest = part_with<primitive::PinRest>("primitive = \"pin-rest\"\n" + frame +
                                                  "height = \"2 cm\"\naround = 24\n");
  CHECK(rest.height == 0.02);
  CHECK(rest.around == 24);
  const auto window = part_with<primitive::Window>(
      "primitive = \"window\"\nextent = [\"9 cm\", \"8 cm\", \"6 mm\"]\n"
      "width = \"4 cm\"\nheight = \"3 cm\"\n");
  CHECK(window.extent == Vec3{0.09, 0.08, 0.006});
  CHECK(window.width == 0.04);
  CHECK(window.height == 0.03);
}

TEST_CASE("config: waypoints of the simulated hand reach their fields, in order") {
  const SessionConfig config =
      session_with("[coupling]\n",
                   "[[device.hand.intent.waypoint]]\nposition = [\"1 cm\", \"0 m\", \"0 m\"]\n"
                   "rest = \"0.5 s\"\n"
                   "[[device.hand.intent.waypoint]]\nposition = [\"0 m\", \"2 cm\", \"0 m\"]\n"
                   "rotation = {axis = [0, 0, 1], angle = \"180 deg\"}\ntime = \"2 s\"\n"
                   "[coupling]\n");
  const IntentConfig& intent = config.device.hand.intent;
  REQUIRE(intent.n_waypoints == 2);
  CHECK(intent.waypoints[0].X_BH.p == Vec3{0.01, 0, 0});
  CHECK(intent.waypoints[0].time == 0);
  CHECK(intent.waypoints[0].rest == 0.5);
  CHECK(intent.waypoints[1].X_BH.p == Vec3{0, 0.02, 0});
  CHECK(intent.waypoints[1].X_BH.q.z == Approx(1));
  CHECK(intent.waypoints[1].time == 2);
  CHECK(intent.waypoints[1].rest == 0);
}

TEST_CASE("config: mistakes in parts, tools and voxels are told with file, line and column") {
  const auto part = [&](const std::string& keys) { return scene_with(kBox, keys); };
  const auto voxel = [](const std::string& keys) {
    return scene_with("[coupling]\n", "[contact.voxel]\n" + keys + "[coupling]\n");
  };
  const auto rigid = [](const std::string& keys) {
    return scene_with("[coupling]\n", "[contact.rigid]\n" + keys + "[coupling]\n");
  };
  const auto tool = [](const std::string& keys) {
    return scene_with("[coupling]\n",
                      "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\n" + keys + "[coupling]\n");
  };
  const std::string thread = "diameter = \"20 mm\"\npitch = \"2 mm\"\n";
  const std::string joint = "diameter = \"4 cm\"\n";
  const std::string frame = "length = \"20 cm\"\nwidth = \"16 mm\"\ndiameter = \"8 mm\"\n";
  const std::string here = "position = [\"1 cm\", \"0 m\", \"0 m\"]\n";
  const auto hand = [](const std::string& keys) {
    return scene_with("[coupling]\n", keys + "[coupling]\n");
  };
  for (const Bad& bad : std::vector<Bad>{
           {part("primitive = \"flywheel\"\n"), "9:13: ",
            "'primitive' is 'flywheel'; known here: box, sphere, peg, hole, gear, bolt, nut, "
            "lower-molar, upper-molar, joint-ball, joint-socket, dimpled-ball, "
            "frame-rail, pin-rest, window"},
           {part("primitive = \"peg\"\ndiameter = \"2 cm\"\n"),
            "7:1: ", "[[object]] has no 'length'"},
           {part("primitive = \"peg\"\ndiameter = \"2 cm\"\nlength = \"4 cm\"\nblock = \"1 m\"\n"),
            "12:1: ", "unknown key 'block' in [[object]]"},
           {part("primitive = \"hole\"\ndiameter = \"20 mm\"\nlength = \"4 cm\"\n"
                 "clearance = \"1 mm\"\nblock = \"22 mm\"\n"),
            "13:9: ", "'block' is no wider than the hole"},
           {part("primitive = \"gear\"\nteeth = 10\nmodule = \"2 mm\"\nwidth = \"1 cm\"\n"
                 "bore = \"15 mm\"\n"),
            "13:8: ", "'bore' reaches the foot of the teeth"},
           {part("primitive = \"gear\"\nteeth = 10\nmodule = \"2 mm\"\nwidth = \"1 cm\"\n"
                 "bore = \"5 mm\"\nbacklash = \"2 mm\"\n"),
            "14:12: ", "'backlash' is as large as the module"},
           {part("primitive = \"gear\"\nteeth = 5\n"), "10:9: ", "whole number from 6 to 200"},
           {part("primitive = \"bolt\"\n" + thread + "depth = \"10 mm\"\nlength = \"4 cm\"\n"),
            "12:9: ", "'depth' reaches the axis"},
           {part("primitive = \"nut\"\n" + thread +
                 "depth = \"1 mm\"\nclearance = \"1 mm\"\nheight = \"1 cm\"\nwidth = \"22 mm\"\n"),
            "15:9: ", "'width' is no wider than the thread"},
           {part("primitive = \"lower-molar\"\nwidth = \"1 cm\"\naround = 100\n"),
            "11:10: ", "'around' is no multiple of 6"},
           {part("primitive = \"joint-ball\"\n" + joint + "stem = \"4 cm\"\nlength = \"5 cm\"\n"),
            "11:8: ", "'stem' is no thinner than the ball"},
           {part("primitive = \"joint-ball\"\n" + joint + "stem = \"1 cm\"\nlength = \"2 cm\"\n"),
            "12:10: ", "'length' ends within the ball"},
           {part("primitive = \"joint-socket\"\n" + joint +
                 "clearance = \"1 mm\"\nwidth = \"4.2 cm\"\nheight = \"3 cm\"\n"),
            "12:9: ", "'width' is no wider than the cavity"},
           {part("primitive = \"joint-socket\"\n" + joint +
                 "clearance = \"1 mm\"\nwidth = \"6 cm\"\nheight = \"2.1 cm\"\n"),
            "13:10: ", "'height' ends above the cavity"},
           {part("primitive = \"joint-socket\"\n" + joint +
                 "clearance = \"1 mm\"\nwidth = \"6 cm\"\nheight = \"3 cm\"\n"
                 "cover = \"170 deg\"\n"),
            "14:9: ", "'cover' is out of range"},
           {part("primitive = \"dimpled-ball\"\n" + joint + "depth = \"5 mm\"\n"),
            "11:9: ", "'depth' is more than a tenth of the diameter"},
           {part("primitive = \"frame-rail\"\n" + frame +
                 "height = \"1 cm\"\n"
                 "clearance = \"1 mm\"\n"),
            "12:12: ", "'diameter' leaves too little of the lugs"},
           {part("primitive = \"frame-rail\"\nlength = \"6 cm\"\nwidth = \"2 cm\"\n"
                 "diameter = \"8 mm\"\n"),
            "10:10: ", "'length' is too short for its lugs"},
           {part("primitive = \"pin-rest\"\n" + frame + "around = 9\n"),
            "13:10: ", "'around' is no multiple of 4"},
           {part("primitive = \"window\"\nextent = [\"4 cm\", \"4 cm\", \"1 mm\"]\n"
                 "width = \"4 cm\"\nheight = \"3 cm\"\n"),
            "11:9: ", "'width' is no less than that of the plate"},
           {hand("[[device.hand.intent.waypoint]]\n" + here), "5:", "'waypoint' leads nowhere"},
           {hand("[device.hand.intent]\nhover_radius = \"1 cm\"\n"
                 "[[device.hand.intent.waypoint]]\n" +
                 here),
            "6:16: ", "'hover_radius' belongs to strokes"},
           {hand("[[device.hand.intent.waypoint]]\n" + here + "[[device.hand.intent.waypoint]]\n" +
                 here),
            "7:1: ", "[[device.hand.intent.waypoint]] has no 'time'"},
           {voxel("size = \"0 mm\"\n"), "6:8: ", "'size' is out of range"},
           {voxel("size = \"1 mm\"\nband = \"0.5 mm\"\n"), "7:8: ", "'band' is out of range"},
           {voxel("offset_layers = 9\n"), "6:17: ", "whole number from 0 to 8"},
           {voxel("field = \"16 bit\"\n"), "6:9: ", "'field' is text; write true or false"},
           {voxel("budget = \"1 ms\"\n"), "6:10: ", "whole number"},
           {voxel("braking = \"1 N\"\n"), "6:11: ", "is a force, not a damping"},
           {rigid("k_s = 2.1\n"), "6:7: ", "'k_s' is out of range"},
           {rigid("k_s = 0\n"), "6:7: ", "'k_s' is out of range"},
           {rigid("margin = \"2 mm\"\n"), "6:10: ", "'margin' is out of range"},
           {rigid("margin = 1e-6\n"), "6:10: ", "'margin'"},
           {rigid("moves = 0\n"), "6:9: ", "whole number from 1 to 64"},
           {rigid("solver = \"direct\"\n"),
            "6:10: ", "'solver' is 'direct'; known here: coulomb, lcp"},
           {rigid("solver = \"lcp\"\n") + "[object.material]\nfriction_static = 0.1\n",
            "6:10: ", "'solver' is \"lcp\", which knows no friction, and object 'block' has"},
           {rigid("ks = 2\n"), "6:1: ", "unknown key 'ks' in [contact.rigid]"},
           {voxel("layers = 2\n"), "6:1: ", "unknown key 'layers' in [contact.voxel]"},
           {scene_with("", "[tool]\nmass = \"1 kg\"\n"), "11:1: ", "[tool] has no 'mesh'"},
           {tool("mass = \"1 kg\"\ndensity = \"1 g/cm³\"\n"),
            "9:11: ", "'density' says what 'mass' and 'inertia' say"},
           {tool("inertia = [\"1 kg·m²\", \"1 kg·m²\", \"2.1 kg·m²\"]\n"),
            "8:11: ", "'inertia' belongs to no body"},
           {tool("inertia = [\"1 kg\", \"1 kg\", \"1 kg\"]\n"),
            "8:12: ", "is a mass, not a moment of inertia"},
           {tool("motion = {kind = \"static\"}\n"), "8:1: ", "unknown key 'motion' in [tool]"}}) {
    bad.check();
  }
}

}  // namespace haptic
