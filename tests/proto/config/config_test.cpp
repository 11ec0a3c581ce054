// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/config/config.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "proto/config/devices.h"
#include "proto/config/quantity.h"
#include "proto/wire/renderer.h"
#include "tests/support/config_text.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;
using test::Bad;
using test::error_of;
using test::kBox;
using test::kScene;
using test::scene_with;
using test::session_with;

constexpr double kRounding = 1e-15;  // relative: one multiplication by a decimal factor

void touch(const fs::path& file) {
  std::ofstream(file) << "OFF\n";
}

}  // namespace

TEST_CASE("quantity: units of one kind agree with their definition in SI") {
  const auto [text, dimension, value] = GENERATE(table<std::string, Dimension, double>({
      {"2 mm", Dimension::kLength, 0.002},
      {"2mm", Dimension::kLength, 0.002},
      {"1 in", Dimension::kLength, 0.0254},
      {"20 µm", Dimension::kLength, 20e-6},
      {"-3.5 cm", Dimension::kLength, -0.035},
      {"100 g", Dimension::kMass, 0.1},
      {"1 kHz", Dimension::kFrequency, 1000},
      {"90 deg", Dimension::kAngle, std::numbers::pi / 2},
      {"180°", Dimension::kAngle, std::numbers::pi},
      {"800 N/m", Dimension::kStiffness, 800},
      {"0.8 N/mm", Dimension::kStiffness, 800},
      {"3 N·s/m", Dimension::kDamping, 3},
      {"3 N*s/m", Dimension::kDamping, 3},
      {"3 N s/m", Dimension::kDamping, 3},
      {"3 Ns/m", Dimension::kDamping, 3},
      {"2 N·m", Dimension::kTorque, 2},
      {"2 N·m/rad", Dimension::kRotationalStiffness, 2},
      {"1 Nm/deg", Dimension::kRotationalStiffness, 180 / std::numbers::pi},
      {"2 mN·m·s/rad", Dimension::kRotationalDamping, 0.002},
      {"250 mA", Dimension::kCurrent, 0.25},
      {"4 GiB", Dimension::kMemory, 4.0 * 1024 * 1024 * 1024},
      {"1e-1 s", Dimension::kTime, 0.1},
  }));
  CAPTURE(text);
  CHECK(std::abs(parse_quantity(text, dimension) - value) <=
        test::tol(kRounding) * std::abs(value));
}

TEST_CASE("quantity: the example of each kind is itself a value of that kind") {
  for (int i = 0; i <= static_cast<int>(Dimension::kMemory); ++i) {
    const Dimension dimension = static_cast<Dimension>(i);
    CAPTURE(example_of(dimension));
    CHECK_NOTHROW(parse_quantity(example_of(dimension), dimension));
  }
}

TEST_CASE("config: a scene is read with its units and defaults") {
  const SessionConfig config = parse_config(kScene, "x.toml");
  const SessionConfig defaults;
  CHECK(view(config.name) == "test");
  CHECK(config.servo_rate == defaults.servo_rate);
  CHECK(config.coupling.translational_stiffness == 800);
  REQUIRE(config.n_objects == 1);
  const ObjectConfig& object = config.objects[0];
  CHECK(view(object.name) == "block");
  CHECK(mesh_name(object) == "primitive:box");
  CHECK(std::get<primitive::Box>(object.primitive).extent == Vec3{0.08, 0.08, 0.08});
  CHECK(object.X_WO == Pose{});
  CHECK(config.map.clutch_button == -1);
  CHECK(fs::path(view(config.file)).is_absolute());
}

TEST_CASE("config: every section reaches its field") {
  const SessionConfig config =
      session_with("[coupling]\n",
                   "max_force = \"9 N\"\n"
                   "max_torque = \"100 mN·m\"\n"
                   "[device.hand]\n"
                   "seed = 7\n"
                   "mass = \"200 g\"\n"
                   "[device.hand.intent]\n"
                   "centre = [\"1 m\", \"2 m\", \"3 m\"]\n"
                   "stroke_time = \"2 s\"\n"
                   "[servo]\nrate = \"2 kHz\"\n"
                   "[contact]\npoll_rate = \"500 Hz\"\nmesh_memory_limit = \"1 GiB\"\n"
                   "spare = false\n"
                   "[sim]\nrate = \"60 Hz\"\n"
                   "[map]\n"
                   "position = [\"4 m\", \"5 m\", \"6 m\"]\n"
                   "motion_scale = 2\n"
                   "force_scale = 0.5\n"
                   "clutch_button = 3\n"
                   "tool_on_grip = {position = [\"7 m\", \"8 m\", \"9 m\"]}\n"
                   "[safety]\nmax_force = \"3 N\"\nsoft_start = \"1 s\"\n"
                   "torque_slew = \"30 N·m/s\"\n"
                   "angular_velocity_limit = \"720 deg/s\"\n"
                   "[coupling]\n"
                   "damping = \"2 Ns/m\"\n");
  CHECK(config.device.max_force == 9);
  CHECK(config.device.max_torque == 0.1);
  CHECK(config.device.hand.seed == 7);
  CHECK(config.device.hand.mass == 0.2);
  CHECK(config.device.hand.intent.centre_B == Vec3{1, 2, 3});
  CHECK(config.device.hand.intent.stroke_time == 2);
  CHECK(config.servo_rate == 2000);
  CHECK(config.contact_poll_rate == 500);
  CHECK(config.mesh_memory_limit == uint64_t{1} << 30);
  CHECK(config.contact_spare == 0);
  CHECK(config.sim_rate == 60);
  CHECK(config.map.X_WB.p == Vec3{4, 5, 6});
  CHECK(config.map.motion_scale == 2);
  CHECK(config.map.force_scale == 0.5);
  CHECK(config.map.clutch_button == 3);
  CHECK(config.map.X_HT.p == Vec3{7, 8, 9});
  CHECK(config.safety.max_force == 3);
  CHECK(config.safety.soft_start == 1);
  CHECK(config.safety.torque_slew == 30);
  CHECK(config.safety.angular_velocity_limit == Approx(4 * std::numbers::pi));
  CHECK(config.coupling.translational_damping == 2);
  CHECK(config.coupling.translational_stiffness == 800);
}

TEST_CASE("config: what bounds torque and turning at the device") {
  const std::string kind = "kind = \"simulated-hand\"\n";
  const auto with = [&](const std::string& keys) { return scene_with(kind, kind + keys); };
  const DeviceConfig plain = parse_config(kScene, "x.toml").device;
  CHECK(plain.continuous_torque == 0);
  CHECK(plain.max_rotational_damping == 0.01);
  CHECK(plain.workspace_turn == 0);
  CHECK(plain.workspace_rest_B == Quat{});
  const DeviceConfig device =
      parse_config(with("continuous_torque = \"50 mN·m\"\n"
                        "max_rotational_damping = \"0.02 N·m·s/rad\"\n"
                        "workspace_turn = \"80 deg\"\n"
                        "workspace_rest = {axis = [0, 0, 2], angle = \"90 deg\"}\n"),
                   "x.toml")
          .device;
  CHECK(device.continuous_torque == Approx(0.05));
  CHECK(device.max_rotational_damping == 0.02);
  CHECK(device.workspace_turn == Approx(80 * std::numbers::pi / 180));
  CHECK(device.workspace_rest_B.z == Approx(std::sqrt(0.5)));
  // no rotation is farther from another than half a turn
  CHECK(error_of(with("workspace_turn = \"181 deg\"\n")).find("x.toml:5") == 0);
  CHECK(error_of(with("continuous_torque = \"0 N·m\"\n")).find("x.toml:5") == 0);
}

TEST_CASE("config: each kind of mistake is told with file, line and column") {
  const Bad bad = GENERATE(values<Bad>({
      {scene_with("\"800 N/m\"", "800"),
       "6:13: ", "'stiffness' needs a unit; write for example \"800 N/m\""},
      {scene_with("\"800 N/m\"", "\"800\""),
       "6:13: ", "needs a unit; write for example \"800 N/m\""},
      {scene_with("800 N/m", "800 mm"), "6:13: ", "is a length, not a stiffness"},
      {scene_with("stiffness = \"800 N/m\"", "rotational_stiffness = \"1 N·m\""),
       "6:24: ", "is a torque, not a rotational stiffness"},
      {scene_with("800 N/m", "800 lbf/in"), "6:13: ", "has an unknown unit"},
      {scene_with("800 N/m", "stiff"), "6:13: ", "does not begin with a number"},
      {scene_with("800 N/m", "nan N/m"), "6:13: ", "is not a finite number"},
      {scene_with("800 N/m", "inf N/m"), "6:13: ", "is not a finite number"},
      {scene_with("800 N/m", "1e999 N/m"), "6:13: ", "too large"},
      {scene_with("800 N/m", "-1 N/m"), "6:13: ", "'stiffness' must not be less than 0"},
      {scene_with("[coupling]", "[device.hand]\nmass = \"0 g\"\n[coupling]"),
       "6:8: ", "'mass' must be greater than 0"},
      {scene_with("[coupling]", "[servo]\nrate = \"-1 kHz\"\n[coupling]"),
       "6:8: ", "'rate' is out of range"},
      {scene_with("[coupling]", "[map]\nmotion_scale = nan\n[coupling]"),
       "6:16: ", "is not a finite number"},
      {scene_with("[coupling]", "[map]\nforce_scale = \"2\"\n[coupling]"),
       "6:15: ", "'force_scale' is text, not a number"},
      {scene_with("\"800 N/m\"", "{a = 1}"), "6:13: ", "is a table, not text with a unit"},
      {scene_with("[coupling]\nstiffness = \"800 N/m\"\n", "hand = 3\n"),
       "5:8: ", "'hand' is a number, not a table"},
      {scene_with("stiffness", "stifness"),
       "6:1: ", "unknown key 'stifness' in [coupling]; did you mean 'stiffness'?"},
      {scene_with("stiffness", "colour"),
       "6:1: ", "unknown key 'colour' in [coupling]; known here: stiffness, damping"},
      {scene_with("[coupling]", "[copling]"), "5:2: ", "did you mean 'coupling'?"},
      {scene_with("", "extend = 1\n"), "11:1: ", "in [[object]]; did you mean 'extent'?"},
      {scene_with("simulated-hand", "simulatedhand"),
       "4:8: ", "'kind' is 'simulatedhand'; did you mean 'simulated-hand'?"},
      {scene_with("name = \"test\"\n", ""),
       "1:1: ", "[session] has no 'name'; add for example name = \"bunny\""},
      {scene_with("[device]\nkind = \"simulated-hand\"\n", ""), "1:1: ", "has no 'device'"},
      {"", "1:1: ", "has no 'session'"},
      {scene_with("extent = [\"80 mm\", \"8 cm\", \"0.08 m\"]\n", ""),
       "7:1: ", "[[object]] has no 'extent'"},
      {scene_with(", \"0.08 m\"", ""), "10:10: ", "'extent' must be 3 values"},
      {scene_with("8 cm", "8 kg"), "10:20: ", "is a mass, not a length"},
      {scene_with("8 cm", "0 cm"), "10:20: ", "must be greater than 0"},
      {scene_with("", kScene.substr(kScene.find("[[object"))),
       "12:8: ", "'name' is used twice ('block')"},
      {scene_with("[[object]]", "[object]"), "7:1: ", "write [[object]] in double brackets"},
      {scene_with("primitive = \"box\"\n", ""), "7:1: ", "[[object]] has no 'mesh'"},
      {scene_with("", "rotation = {angle = \"1 deg\"}\n"),
       "11:12: ", "[object.rotation] has no 'axis'"},
      {scene_with("", "rotation = {axis = [0, 0, 0], angle = \"1 rad\"}\n"),
       "11:20: ", "has no direction"},
      {scene_with("", "rotation = {quaternion = [0, 0, 0, 2]}\n"), "11:26: ", "has not length 1"},
      {scene_with("name = \"test\"", "name = \"a test\""),
       "2:8: ", "'name' cannot be the name of a session; use 1 to 32 letters"},
      {scene_with("[coupling]", "[sim]\nrate = \"10 Hz\"\n[coupling]"),
       "6:8: ", "'rate' is out of range"},
      {scene_with("", "motion = {kind = \"static\", frequency = \"1 Hz\"}\n"),
       "11:28: ", "unknown key 'frequency' in [object.motion]"},
      {scene_with("", "motion = {kind = \"oscillate\", amplitude = \"5 mm\"}\n"),
       "11:10: ", "[object.motion] has no 'frequency'"},
      {scene_with("[coupling]", "[map]\nclutch_button = 32\n[coupling]"),
       "6:17: ", "whole number from 0 to 31"},
      {scene_with("[coupling]", "[servo]\nwake = \"spin\"\n[coupling]"),
       "6:8: ", "'wake' is 'spin'; known here: sleep, hybrid"},
      {scene_with("name = \"test\"", "name = \"test\"\nrealtime = \"no\""),
       "3:12: ", "'realtime' is text; write true or false"},
      {scene_with("\"test\"", "\"" + std::string(64, 'a') + "\""),
       "2:8: ", "'name' is longer than 63 characters"},
      {scene_with("\"test\"", "\"\""), "2:8: ", "'name' is empty"},
      {scene_with("simulated-hand", "replay"), "3:1: ", "[device] has no 'replay'"},
      {scene_with("simulated-hand", "woodenhaptics"),
       "3:1: ", "[device] has no 'serial'; add for example [device.serial] with path"},
      {scene_with("[coupling]", "[device.serial]\nmax_current = \"1 A\"\n[coupling]"),
       "5:1: ", "[device.serial] has no 'path'"},
      {scene_with("[coupling]",
                  "[device.serial]\npath = \"/dev/x\"\nmax_current = \"6.1 A\"\n[coupling]"),
       "7:15: ", "'max_current' is out of range"},
      {scene_with("= \"test\"", "= test"), "2:", "not TOML: "},
      {scene_with("", "name = \"b\"\n"), "11:", "not TOML: "},
  }));
  bad.check();
}

TEST_CASE("config: a serial device is read with its units, the examples in configs are sound") {
  const SessionConfig config =
      session_with("kind = \"simulated-hand\"\n",
                   "kind = \"woodenhaptics\"\n[device.serial]\npath = \"/dev/ttyACM7\"\n"
                   "max_current = \"2500 mA\"\n[device.hand.intent]\ndirection = [0, 3, 4]\n");
  CHECK(config.device.kind == DeviceKind::kWoodenHaptics);
  CHECK(view(config.device.serial.path) == "/dev/ttyACM7");
  CHECK(config.device.serial.max_current == 2.5);
  CHECK(config.device.serial.velocity_cutoff == SerialConfig{}.velocity_cutoff);
  CHECK(config.device.hand.intent.direction_B == Vec3{0, 0.6, 0.8});
  const SessionConfig example = load_config(test::from_source("configs/woodenhaptics.toml"));
  CHECK(example.device.kind == DeviceKind::kWoodenHaptics);
}

TEST_CASE("config: one object too many is refused at its place and so is a body or a joint") {
  const std::string begin = kScene.substr(0, kScene.find("[[object]]"));
  const auto objects = [](uint32_t n, const std::string& more) {
    std::string text;
    for (uint32_t i = 0; i < n; ++i) {
      text += "[[object]]\nname = \"o" + std::to_string(i) +
              "\"\nprimitive = \"sphere\"\nsize = \"1 cm\"\n" + more;
    }
    return text;
  };
  const std::string body = "[object.body]\nmass = \"1 g\"\n";
  const auto refusal = [&](const std::string& text, uint32_t line, uint32_t column,
                           const std::string& what) {
    CHECK_THAT(error_of(begin + text),
               Catch::StartsWith("x.toml:" + std::to_string(line) + ":" + std::to_string(column)) &&
                   Catch::Contains(what + " is the most a session can hold, "));
  };
  refusal(objects(kMaxObjects + 1, ""), 6 + 4 * kMaxObjects + 2, 8, "256");
  refusal(objects(kMaxBodies + 1, body), 6 + 6 * kMaxBodies + 5, 1, "64");
  std::string joints = objects(1, body);
  for (uint32_t i = 0; i <= kMaxJoints; ++i) {
    joints += "[[joint]]\nkind = \"fixed\"\nobject = \"o0\"\n";
  }
  refusal(joints, 6 + 6 + 3 * kMaxJoints + 2, 8, "64");
  CHECK_NOTHROW(parse_config(begin + objects(kMaxObjects, ""), "x.toml"));
  CHECK_NOTHROW(parse_config(begin + objects(kMaxBodies, body), "x.toml"));
}

TEST_CASE("config: a rotation by axis and angle is the quaternion of the half angle") {
  const SessionConfig config =
      session_with("", "rotation = {axis = [0, 0, 2], angle = \"90 deg\"}\n");
  const Quat q = config.objects[0].X_WO.q;
  const double half = std::sqrt(0.5);
  CHECK(std::abs(q.z - half) <= test::tol(1e-15));
  CHECK(std::abs(q.w - half) <= test::tol(1e-15));
}

TEST_CASE("config: a mesh is looked for beside the file first, then in the mesh folders") {
  const test::TemporaryFolder scene_folder, mesh_folder;
  const fs::path scenes = scene_folder.path(), meshes = mesh_folder.path();
  const test::Environment environment("HAPTICD_MESHES", meshes.string());
  const std::string object =
      scene_with(kBox, "mesh = \"shape_of_test.off\"\nunit = \"mm\"\nsize = \"100 mm\"\n");
  const auto mesh_of = [&](const std::string& text) {
    return std::string(view(parse_config(text, (scenes / "x.toml").string()).objects[0].mesh));
  };
  CHECK_THROWS_WITH(mesh_of(object), Catch::Contains("x.toml:9:8: 'mesh' was not found") &&
                                         Catch::Contains(meshes.string()) &&
                                         Catch::Contains("build/meshes") &&
                                         Catch::Contains("./run meshes"));
  touch(meshes / "shape_of_test.off");
  CHECK(mesh_of(object) == (meshes / "shape_of_test.off").string());
  touch(scenes / "shape_of_test.off");
  CHECK(mesh_of(object) == (scenes / "shape_of_test.off").string());
  std::string packaged = object;
  packaged.replace(packaged.find("shape_of"), 0, "package:");
  CHECK(mesh_of(packaged) == (meshes / "shape_of_test.off").string());
}

TEST_CASE("config: a mesh must state its unit and size") {
  const test::TemporaryFolder temporary;
  const fs::path meshes = temporary.path();
  touch(meshes / "shape_of_test.off");
  const test::Environment environment("HAPTICD_MESHES", meshes.string());
  const std::string mesh = "mesh = \"shape_of_test.off\"\n";
  CHECK_THAT(error_of(scene_with(kBox, mesh + "size = \"1 cm\"\n")),
             Catch::StartsWith("x.toml:7:1: [[object]] has no 'unit'"));
  CHECK_THAT(error_of(scene_with(kBox, mesh + "unit = \"any\"\n")),
             Catch::StartsWith("x.toml:7:1: [[object]] has no 'size'"));
  // a real unit says how large it is
  CHECK(session_with(kBox, mesh + "unit = \"mm\"\n").objects[0].size == 0);
  CHECK_THAT(error_of(scene_with(kBox, mesh + "unit = \"yard\"\nsize = \"1 cm\"\n")),
             Catch::StartsWith("x.toml:10:8: 'unit' is 'yard'; known here: m, mm, cm, in, any"));
  const SessionConfig config =
      session_with(kBox, mesh + "unit = \"any\"\nsize = \"1 cm\"\nopen = true\n");
  CHECK(config.objects[0].unit == 0);
  CHECK(config.objects[0].size == 0.01);
  CHECK(config.objects[0].allow_open == 1);
}

TEST_CASE("config: a colour is six hexadecimal digits, and without one objects differ") {
  const auto with = [&](const std::string& colour) {
    return scene_with(kBox,
                      kBox + "colour = \"" + colour + "\"\n[[object]]\nname = \"b\"\n" + kBox);
  };
  const SessionConfig config = parse_config(with("#fF8001"), "x");
  CHECK(config.objects[0].colour == 0xff8001);
  CHECK(config.objects[1].colour != session_with("", "").objects[0].colour);
  const std::string tool =
      "[tool]\nprimitive = \"sphere\"\nsize = \"1 cm\"\ncolour = \"#000001\"\n";
  CHECK(parse_config(scene_with("", "") + tool, "x").tool.colour == 1);
  for (const char* bad : {"red", "#12345", "#1234567", "#12345g", "#-12345", "1234567", "#"}) {
    CHECK_THAT(error_of(with(bad)), Catch::StartsWith("x.toml:11:10: 'colour' is '" +
                                                      std::string(bad) + "'; write six"));
  }
}

TEST_CASE(
    "config: a replay takes its file from the folder of the config, and a lever needs a column") {
  const test::TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  const std::string origin = (folder / "x.toml").string();
  const auto scene = [&](const std::string& replay) {
    return scene_with("kind = \"simulated-hand\"\n",
                      "kind = \"replay\"\n[device.replay]\n" + replay);
  };
  const SessionConfig config = parse_config(
      scene("path = \"hand.csv\"\ncolumn = \"lever_rad\"\nlever_arm = \"75 mm\"\naxis = [0, 2, 0]\n"
            "resampling = \"hold\"\nmax_gap = \"5 ms\"\n"),
      origin);
  CHECK(view(config.device.replay.path) == (folder / "hand.csv").string());
  CHECK(config.device.replay.lever_arm == 0.075);
  CHECK(config.device.replay.axis_B == Vec3{0, 1, 0});
  CHECK(config.device.replay.resampling == Resampling::kHold);
  CHECK(config.device.replay.max_gap == 0.005);
  const ReplayConfig part = parse_config(scene("path = \"hand.csv\"\nspeed = 0.5\nfrom = \"2 s\"\n"
                                               "to = \"4 s\"\nloop = true\nclosed_loop = true\n"),
                                         (folder / "x.toml").string())
                                .device.replay;
  CHECK((part.speed == 0.5 && part.from == 2 && part.to == 4));
  CHECK((part.loop == 1 && part.closed_loop == 1));
  for (const std::string wrong : {"speed = 0", "speed = 100", "from = \"-1 s\"", "to = \"0 s\"",
                                  "loop = 2", "closed_loop = \"yes\"", "from = 2"}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(parse_config(scene("path = \"hand.csv\"\n" + wrong + "\n"), "x.toml"),
                    ConfigError);
  }
  CHECK_THROWS_WITH(parse_config(scene("path = \"hand.csv\"\nlever_arm = \"1 m\"\n"), origin),
                    Catch::Contains("has no 'column'"));
}

TEST_CASE("config: a material with a grating and one with an image") {
  const test::TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  std::ofstream(folder / "grain.pgm") << "P2\n# two by two\n2 2\n15\n0 15\n3 0\n";
  const std::string origin = (folder / "x.toml").string();
  const auto with = [&](const std::string& material) {
    return parse_config(scene_with(kBox, kBox + "[object.material]\n" + material), origin);
  };
  SessionConfig config = with(
      "friction_static = 0.5\nfriction_dynamic = 0.4\nfriction_viscous = \"2 N·s/m\"\n"
      "stiffness_share = 0.7\ncrease_angle = \"0.5 rad\"\ntexture = {kind = \"grating\", "
      "amplitude = \"0.1 mm\", wavelength = \"2 mm\", direction = [0, 3, 0]}\n");
  const MaterialConfig& m = config.objects[0].material;
  CHECK(m.friction_static == 0.5);
  CHECK(m.friction_dynamic == 0.4);
  CHECK(m.friction_viscous == 2);
  CHECK(m.stiffness_share == 0.7);
  CHECK(m.crease_angle == 0.5);
  CHECK(m.texture.kind == TextureKind::kGrating);
  CHECK(m.texture.amplitude == Approx(1e-4));
  CHECK(m.texture.period == Approx(2e-3));
  CHECK(m.texture.direction_O == Vec3{0, 1, 0});

  const std::string image =
      "texture = {kind = \"image\", path = \"grain.pgm\", amplitude = \"1 mm\", tile = \"1 cm\"}\n";
  config = with(image);
  CHECK(config.n_images == 1);
  CHECK(config.images[0].width == 2);
  CHECK(config.images[0].grey[1] == 255);
  CHECK(config.images[0].grey[2] == 51);

  // binary pixels, and unusable files
  std::ofstream(folder / "grain.pgm", std::ios::binary) << "P5 2 1 255\n" << '\x0a' << '\xff';
  config = with(image);
  CHECK(config.images[0].grey[0] == 10);
  CHECK(config.images[0].grey[1] == 255);
  for (const char* bad : {"P3 1 1 255 0", "P2 65 1 255", "P2 2 2 255 1 2 3", "P2 1 1 65535 7",
                          "P2 1 1 7 9", "P2 0 1 255", ""}) {
    std::ofstream(folder / "grain.pgm") << bad;
    CAPTURE(bad);
    CHECK_THROWS_WITH(with(image), Catch::Contains("'path'") && Catch::Contains("grain.pgm") &&
                                       Catch::Contains("grey PGM"));
  }
  CHECK_THROWS_WITH(with("friction_dynamic = 0.5\n"),
                    Catch::Contains("larger than friction_static"));
  CHECK_THROWS_WITH(with("stiffness_share = 1.5\n"), Catch::Contains("'stiffness_share'"));
  CHECK_THROWS_WITH(with("texture = {kind = \"grating\", amplitude = \"1 mm\"}\n"),
                    Catch::Contains("has no 'wavelength'"));
  CHECK_THROWS_WITH(with("sticky = 1\n"), Catch::Contains("'sticky'"));
}

TEST_CASE("config: the renderer and its radius") {
  CHECK(parse_config(kScene, "x.toml").renderer == Renderer::kGodObject3);
  const SessionConfig config =
      session_with("[coupling]", "[contact]\nproxy_radius = \"2 mm\"\n[coupling]");
  CHECK(config.proxy_radius == Approx(2e-3));
}

TEST_CASE("config: the servo sleeps unless the file asks it to spin") {
  CHECK(parse_config(kScene, "x.toml").servo_wake == Wake::kSleep);
  const std::string hybrid = scene_with("[coupling]", "[servo]\nwake = \"hybrid\"\n[coupling]");
  CHECK(parse_config(hybrid, "x.toml").servo_wake == Wake::kHybrid);
}

TEST_CASE("config: a file that is not there is one line") {
  CHECK_THROWS_WITH(load_config("/nowhere/x.toml"),
                    Catch::StartsWith("/nowhere/x.toml: cannot be read"));
}

TEST_CASE("config: the scenes that are shipped load") {
  const test::TemporaryFolder temporary;
  const fs::path meshes = temporary.path();
  touch(meshes / "bunny00.off");
  const test::Environment environment("HAPTICD_MESHES", meshes.string());
  size_t n = 0;
  for (const auto& entry : fs::directory_iterator(test::from_source("configs"))) {
    if (entry.path().extension() != ".toml") continue;
    CAPTURE(entry.path());
    const SessionConfig config = load_config(entry.path().string());
    CHECK(view(config.name) == entry.path().stem().string());
    CHECK(config.n_objects > 0);
    ++n;
  }
  CHECK(n >= 2);
}

TEST_CASE("config: what the bunny scene calls a default is the default") {
  const test::TemporaryFolder temporary;
  const fs::path meshes = temporary.path();
  touch(meshes / "bunny00.off");
  const test::Environment environment("HAPTICD_MESHES", meshes.string());
  const SessionConfig bunny = load_config(test::from_source("configs/bunny.toml"));
  const SessionConfig defaults;
  CHECK(bunny.servo_rate == defaults.servo_rate);
  CHECK(bunny.servo_wake == defaults.servo_wake);
  CHECK(bunny.contact_poll_rate == defaults.contact_poll_rate);
  CHECK(bunny.sim_rate == defaults.sim_rate);
  CHECK(bunny.mesh_memory_limit == defaults.mesh_memory_limit);
  CHECK(bunny.contact_spare == defaults.contact_spare);
  CHECK(bunny.map.X_WB == defaults.map.X_WB);
  CHECK(bunny.device.max_force == defaults.device.max_force);
  CHECK(bunny.device.hand.mass == defaults.device.hand.mass);
  CHECK(bunny.device.hand.encoder_step == Approx(defaults.device.hand.encoder_step));
  CHECK(bunny.device.hand.velocity_cutoff == defaults.device.hand.velocity_cutoff);
  CHECK(bunny.coupling.translational_stiffness == defaults.coupling.translational_stiffness);
  CHECK(bunny.safety.max_force == defaults.safety.max_force);
  CHECK(bunny.safety.soft_start == defaults.safety.soft_start);
}

}  // namespace haptic
