// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of one's own as it becomes a session, without a session that runs.
#include <cmath>
#include <fstream>

#include "clients/hapt/mesh_scene.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/ipc/sessions.h"
#include "tests/process/hapt_command.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/data.h"
#include "tests/support/mesh_files.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

/// A part as text STL, its middle away from the origin of the file.
void write_part(const std::string& path, Soup soup) {
  for (Vec3& v : soup.vertices) v += {50, 30, 20};
  std::ofstream(path) << as_text_stl(soup);
}

void write_stl(const std::string& path, double x, double y, double z) {
  write_part(path, make_box({x, y, z}));
}

const std::string kHead = "[session]\nname = \"mine\"\n[device]\nkind = \"simulated-hand\"\n";

/// The session of `hapt demo --mesh` for that part, in lockstep: the same figures on every machine.
Ran touch(const std::string& folder, const OwnMesh& part) {
  std::ofstream(folder + "/mine.toml") << session_text(part);
  return hapt("eval --config mine.toml --for 5 --json", folder);
}

}  // namespace

TEST_CASE("own mesh: parts of any size are touched as large as their files say") {
  const TemporaryRuntimeFolder folder;
  struct Part {
    double x, y, z;
    const char* unit;
    double size;
  };
  for (const Part& part : {Part{80, 40, 20, "mm", 0}, Part{6, 5, 4, "mm", 0},
                           Part{400, 30, 30, "mm", 0}, Part{3, 2, 1, "", 0.06}}) {
    CAPTURE(part.x);
    write_stl(folder.path() + "/part.stl", part.x, part.y, part.z);
    const Ran ran = touch(folder.path(), {folder.path() + "/part.stl", part.unit, part.size});
    CAPTURE(ran.output);
    CHECK(ran.code == 0);
    CHECK(figure(ran.output, "ticks in contact") > 0);
  }
}

TEST_CASE("own mesh: a hollow or flat part is touched most of the time") {
  const TemporaryRuntimeFolder folder;
  for (const bool is_ring : {true, false}) {
    CAPTURE(is_ring);
    if (is_ring) {
      write_part(folder.path() + "/part.stl", make_torus(40, 8, 48, 16));
    } else {
      write_stl(folder.path() + "/part.stl", 100, 100, 5);
    }
    const Ran ran = touch(folder.path(), {folder.path() + "/part.stl", "mm"});
    CAPTURE(ran.output);
    CHECK(ran.code == 0);
    CHECK(figure(ran.output, "share of ticks in contact") > 50);
  }
}

TEST_CASE("hapt demo --mesh: what the hand cannot reach, or has no unit, is said in a sentence") {
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
  CHECK(running_sessions().empty());
}

TEST_CASE("hapt bake: prints an object that a session file takes as it is") {
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

TEST_CASE("hapt demo: the hand touches the bunny within a second, and most of the time") {
  if (!test::find_mesh("bunny00.off")) return;
  const TemporaryRuntimeFolder folder;
  // in lockstep: the same figures on every machine
  const Ran ran = hapt("eval --config bunny.toml --for 20 --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "share of ticks in contact") > 50);
  CHECK(figure(ran.output, "time of the first touch") < 1);
}

}  // namespace haptic
