// SPDX-License-Identifier: GPL-3.0-or-later
// `hapt demo` as a newcomer sees it, and a mesh of one's own, on the real binaries.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

size_t columns(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

std::string last_line(const std::string& text) {
  const size_t end = text.find_last_not_of('\n');
  const size_t begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

/// A box as text STL, its lower corner at (10, 10, 10) in units of the file.
void write_stl(const std::string& path, double x, double y, double z) {
  const double corner[2][3] = {{10, 10, 10}, {10 + x, 10 + y, 10 + z}};
  // corners by bits x, y, z; counter-clockwise seen from outside
  const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::ofstream stl(path);
  stl << "solid box\n";
  for (const auto& face : faces) {
    stl << "facet normal 0 0 0\nouter loop\n";
    for (const int i : face) {
      stl << "vertex " << corner[i & 1][0] << ' ' << corner[i >> 1 & 1][1] << ' '
          << corner[i >> 2 & 1][2] << '\n';
    }
    stl << "endloop\nendfacet\n";
  }
  stl << "endsolid box\n";
}

/// A torus as text STL, its middle at (10, 10, 10).
void write_ring(const std::string& path, double radius, double thickness) {
  constexpr int kAround = 48, kAcross = 16;
  const auto write_vertex = [&](std::ostream& out, int i, int j) {
    const double a = 2 * M_PI * (i % kAround) / kAround, b = 2 * M_PI * (j % kAcross) / kAcross;
    const double r = radius + thickness * std::cos(b);
    out << "vertex " << 10 + r * std::cos(a) << ' ' << 10 + r * std::sin(a) << ' '
        << 10 + thickness * std::sin(b) << '\n';
  };
  std::ofstream stl(path);
  stl << "solid ring\n";
  for (int k = 0; k < 2 * kAround * kAcross; ++k) {
    const int i = k / 2 / kAcross, j = k / 2 % kAcross;
    stl << "facet normal 0 0 0\nouter loop\n";
    write_vertex(stl, i, j);
    if (k % 2 == 0) write_vertex(stl, i + 1, j);
    write_vertex(stl, i + 1, j + 1);
    if (k % 2 == 1) write_vertex(stl, i, j + 1);
    stl << "endloop\nendfacet\n";
  }
  stl << "endsolid ring\n";
}

const std::string kHead = "[session]\nname = \"mine\"\n[device]\nkind = \"simulated-hand\"\n";

}  // namespace

TEST_CASE("hapt demo: what a newcomer sees fits a screen, and its last line says how it went") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  // the default scene of a checkout, and of an installed program
  const std::string scene = GENERATE(as<std::string>(), "bunny", "peg");
  if (scene == "bunny" && !test::find_mesh("bunny00.off")) return;
  const Ran ran = hapt("demo " + scene + " --for 6", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(lines(ran.output) <= 24);
  CHECK_FALSE(has(ran.output, "\x1b"));
  CHECK_FALSE(has(ran.output, "\r"));
  std::istringstream text(ran.output);
  for (std::string line; std::getline(text, line);) {
    CAPTURE(line);
    CHECK(columns(line) <= 80);
  }
  const std::string said = last_line(ran.output);
  CHECK(said.rfind("passed: 6 s with ", 0) == 0);
  CHECK(has(said, " % in contact; next: hapt demo --list"));
  // of the last five seconds, not of an instant
  const size_t share = ran.output.find(" % in contact   force up to ");
  REQUIRE(share != std::string::npos);
  CHECK(has(ran.output.substr(0, share), " of 6 s   "));
  CHECK(std::stoi(ran.output.substr(share - 3, 3)) >= 20);
  CHECK(std::stod(ran.output.substr(share + 28)) > 0.5);
}

TEST_CASE("hapt demo: the hand touches the bunny within a second, and most of the time") {
  if (!programs_are_built() || !test::find_mesh("bunny00.off")) return;
  const TemporaryRuntimeFolder folder;
  // in lockstep: the same figures on every machine
  const Ran ran = hapt("eval --config bunny.toml --for 20 --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "share of ticks in contact") > 50);
  CHECK(figure(ran.output, "time of the first touch") < 1);
}

TEST_CASE("hapt demo: the scenes are listed, each with its command") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("demo --list", folder.path());
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "hapt demo bunny          the Stanford bunny\n"));
  CHECK(has(last_line(ran.output), "hapt demo --mesh part.stl --unit mm"));
}

TEST_CASE("hapt demo --mesh: a part of one's own is touched, as large as its file says") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  struct Part {
    double x, y, z;
    const char *words, *mesh;
  };
  const Part part = GENERATE(values<Part>({{80, 40, 20, "--unit mm", "part.stl"},
                                           {6, 5, 4, "--unit mm", "small part.stl"},
                                           {400, 30, 30, "--unit mm", "rod.stl"},
                                           {3, 2, 1, "--size '60 mm'", "no-unit.stl"}}));
  write_stl(folder.path() + "/" + part.mesh, part.x, part.y, part.z);
  const std::string words = std::string("demo --mesh '") + part.mesh + "' " + part.words;
  const Ran ran = hapt(words + " --for 5 -o run.mcap", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(last_line(ran.output).rfind("passed: 5 s with " + std::string(part.mesh), 0) == 0);
}

TEST_CASE("hapt demo --mesh: a hollow or flat part is touched most of the time") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const std::string part = GENERATE(as<std::string>(), "ring", "plate");
  if (part == "ring") {
    write_ring(folder.path() + "/part.stl", 40, 8);
  } else {
    write_stl(folder.path() + "/part.stl", 100, 100, 5);
  }
  const Ran ran = hapt("demo --mesh part.stl --unit mm --for 4 --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "share of ticks in contact") > 50);
}

TEST_CASE("hapt demo --mesh: what the hand cannot reach, or has no unit, is said in a sentence") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  write_stl(folder.path() + "/part.stl", 80, 40, 20);
  struct Typed {
    const char* words;
    int code;
    const char* says;
  };
  const Typed typed = GENERATE(values<Typed>({
      {"--unit m", 1,
       "FAILED: the object 'part' lies 9.6 m beyond what the hand reaches; it is 80 m long: make "
       "it "
       "smaller, or was unit \"m\" meant as \"mm\"?\n"},
      {"", 2, "a mesh file has no unit; add --unit mm"},
      {"--unit any", 2, "a mesh file has no unit; add --unit mm"},
      {"--unit furlong", 2, "'furlong'; known here: m, mm"},
  }));
  const Ran ran = hapt(std::string("demo --mesh part.stl ") + typed.words, folder.path());
  CAPTURE(typed.words, ran.output);
  CHECK(ran.code == typed.code);
  CHECK(has(ran.output, typed.says));
}

TEST_CASE("hapticd --check-config: the meshes are opened, their size and place looked at") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  write_stl(folder.path() + "/part.stl", 80, 40, 20);
  std::ofstream(folder.path() + "/broken.stl") << "solid nothing\n";
  struct Scene {
    const char* object;
    int code;
    const char* says;
  };
  const Scene scene = GENERATE(values<Scene>({
      {"mesh = 'part.stl'\nunit = 'mm'\n", 0, "mine.toml: ok, session 'mine', 1 object\n"},
      {"mesh = 'part.stl'\nunit = 'mm'\nposition = ['500 mm', '0 m', '0 m']\n", 0,
       "mine.toml: warning: the object 'part' lies 0.44 m beyond what the hand reaches; move it to "
       "position = [\"-50 mm\", \"-30 mm\", \"-20 mm\"]\n"},
      {"mesh = 'part.stl'\nunit = 'm'\n", 0, "was unit \"m\" meant as \"mm\"?\n"},
      {"mesh = 'part.stl'\nunit = 'mm'\nsize = '80 m'\n", 2, "states size 80000 mm but the file"},
      {"mesh = 'broken.stl'\nunit = 'mm'\n", 2, "broken.stl"},
      {"mesh = 'missing.stl'\nunit = 'mm'\n", 2, "was not found"},
      {"mesh = 'part.stl'\nunit = 'any'\n", 2, "has no 'size'"},
  }));
  std::ofstream(folder.path() + "/mine.toml") << kHead << "[[object]]\nname = 'part'\n"
                                              << scene.object;
  const Ran ran = shell("hapticd --check-config mine.toml", folder.path());
  CAPTURE(scene.object, ran.output);
  CHECK(ran.code == scene.code);
  CHECK(has(ran.output, scene.says));
  CHECK(lines(ran.output) == (has(ran.output, "warning") ? 2 : 1));
}

TEST_CASE("hapt bake: prints an object that a session file takes as it is") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const std::string mesh = GENERATE(as<std::string>(), "part.stl", "a \"quoted\\\" part.stl");
  write_stl(folder.path() + "/" + mesh, 80, 40, 20);
  const std::string unit = GENERATE(as<std::string>(), "--unit mm", "--unit 0.0254",
                                    "--unit '25.4 mm'", "--unit any --size '80 mm'", "--size 0.08");
  const Ran baked = hapt("bake " + test::word(mesh) + " " + unit, folder.path());
  INFO(baked.output);
  REQUIRE(baked.code == 0);
  CHECK(has(baked.output, ": 12 triangles, 8 vertices, "));
  CHECK(has(baked.output, ", closed"));
  if (unit == "--unit mm") CHECK(has(baked.output, ", 80 x 40 x 20 mm, "));
  const size_t block = baked.output.find("[[object]]");
  REQUIRE(block != std::string::npos);
  std::ofstream(folder.path() + "/mine.toml") << kHead << baked.output.substr(block);
  const Ran checked = shell("hapticd --check-config mine.toml", folder.path());
  INFO(checked.output);
  CHECK(checked.code == 0);
  CHECK(has(checked.output, "ok, session 'mine', 1 object\n"));
}

TEST_CASE("configs/lever.toml: its recording is there, and plays") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("demo --config lever.toml -o lever.mcap --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "samples of the recorded hand") == 8001);
  CHECK(figure(ran.output, "share of ticks in contact") > 30);
}

}  // namespace haptic
