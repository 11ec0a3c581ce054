// SPDX-License-Identifier: GPL-3.0-or-later
// One rule for quantities: the same invalid texts at every input of the programs that takes a
// number with a unit.
#include <fstream>
#include <string>
#include <vector>

#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::has;
using test::Ran;
using test::word;

/// An input: a shell command line that takes the quantity as its last word.
struct Door {
  std::string line, unit;
  bool takes_bare = false;  // a bare number is allowed
};

const std::vector<Door> kDoors{
    {"sh config.sh", "N/m"},  // [coupling] stiffness of a session file
    {"hapt set --session doors stiffness", "N/m"},
    {"hapt bake t.off --unit", "m", true},
    {"hapt bake t.off --size", "mm", true},
    {"hapt bake t.off --voxel", "mm"},
    {"hapt eval mesh t.off --ticks 10 --size", "mm", true},
    {"hapt eval mesh t.off --ticks 10 --radius", "mm", true},
    {"hapt eval mesh t.off --ticks 10 --stiffness", "N/m", true},
    {"hapt demo --config missing.toml --for", "s", true},
    {"hapt top --session missing -d", "s", true},
    {"hapt record --session missing -o x.mcap --for", "s", true},
    {"hapt passivity --stiffness", "N/m", true},
    {"hapt torture --minutes", "min", true},
    {"haptic-emulator --hover", "mm"},
};

struct Wrong {
  std::string text, says;  // % stands for the unit
  bool lists_units = true;
};

const std::vector<Wrong> kWrong{
    {"nan %", "is not a finite number"},
    {"inf %", "is not a finite number"},
    {"1e300 %", "is too large"},
    {"1e999 %", "is too large or too small"},
    {"8,5 %", "has a comma; the decimal sign is a point, as in 8.5"},
    {"80 furlongs", "has an unknown unit"},
    {"80 A", "is a current, not a"},
    {"80 %\x1b[31m", "has an unknown unit"},
    {"80 %" + std::string(5000, 'x'), "has an unknown unit"},
    {"-1e-9 %", "(\"-1e-9 ", false},
};

/// Texts that no input accepts as a number; `--unit` also knows words.
const std::vector<std::string> kNoNumber{"%", "", "\x1b[2J", "about 80 %"};

std::string with_unit(std::string text, const std::string& unit) {
  if (const size_t at = text.find('%'); at != std::string::npos) text.replace(at, 1, unit);
  return text;
}

void prepare_quantities(const std::string& folder) {
  std::ofstream(folder + "/t.off")  // a corner of a cube of 0.08
      << "OFF\n4 4 0\n0 0 0\n0.08 0 0\n0 0.08 0\n0 0 0.08\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  std::ofstream(folder + "/config.sh") << R"(printf '%s\n' '[session]' 'name = "doors"' \
  '[device]' 'kind = "simulated-hand"' '[coupling]' "stiffness = '''$1'''" >doors.toml
exec hapticd --check-config doors.toml
)";
}

/// With a separate cache.
Ran run_with_cache(const std::string& line, const std::string& folder) {
  return test::shell("export HAPTICD_CACHE=cache; " + line, folder);
}

/// Checks for one relevant line and an exit code other than 0.
void check_refusal(const Ran& ran, const std::string& says) {
  CHECK(ran.code != 0);
  CHECK(test::lines(ran.output) == 1);
  CHECK(test::problem_of_message(ran.output) == "");
  CHECK(has(ran.output, says));
}

}  // namespace

TEST_CASE("quantities: the same wrong text is refused at every door, with what is known") {
  const test::TemporaryRuntimeFolder folder;
  prepare_quantities(folder.path());
  test::HapticdProcess hapticd({test::write_quiet_config(folder.path()), "--session", "doors"},
                               folder.path());
  test::Watcher watcher("doors");
  REQUIRE(watcher.wait_for_all());
  for (const Door& door : kDoors) {
    for (const Wrong& wrong : kWrong) {
      const std::string text = with_unit(wrong.text, door.unit);
      const Ran ran = run_with_cache(door.line + " " + word(text), folder.path());
      CAPTURE(door.line, text, ran.output);
      // TOML refuses control characters itself
      const bool is_toml = door.unit == "N/m" && has(ran.output, "not TOML");
      check_refusal(ran, is_toml ? "not TOML" : wrong.says);
      if (wrong.lists_units && !is_toml) CHECK(has(ran.output, "; known units: "));
    }
    if (has(door.line, "--unit")) continue;
    for (const std::string& text : kNoNumber) {
      const Ran ran =
          run_with_cache(door.line + " " + word(with_unit(text, door.unit)), folder.path());
      CAPTURE(door.line, text, ran.output);
      check_refusal(ran, "");
    }
  }
}

TEST_CASE("quantities: with its unit a value is the same at every door, bare where it ever was") {
  const test::TemporaryRuntimeFolder folder;
  prepare_quantities(folder.path());
  for (const Door& door : kDoors) {
    if (door.unit == "min" || has(door.line, "emulator") || has(door.line, "set")) continue;
    CAPTURE(door.line);
    const std::string value = door.unit == "m" || door.unit == "mm" ? "2 " : "80 ";
    for (const std::string& text :
         {value + door.unit, value.substr(0, value.size() - 1) + door.unit}) {
      const Ran ran = run_with_cache(door.line + " " + word(text), folder.path());
      CAPTURE(text, ran.output);
      // missing sessions and files are detected after the arguments are parsed
      CHECK((ran.code != 2 || has(ran.output, "no such session file")));
    }
    const Ran bare = run_with_cache(door.line + " 0.05", folder.path());
    CAPTURE(bare.output);
    if (door.takes_bare && door.unit != "N/m") {
      CHECK((bare.code != 2 || has(bare.output, "no such session file")));
    } else if (!door.takes_bare) {
      check_refusal(bare, "needs a unit");
    }
  }
  for (const std::string words :
       {"--unit '1 mm'", "--unit mm", "--unit 1e-3", "--size '80 mm'", "--size 0.08"}) {
    const std::string side = has(words, "unit") ? "0.08" : "80";
    CAPTURE(words);
    CHECK(has(run_with_cache("hapt bake t.off " + words, folder.path()).output,
              ", " + side + " x " + side + " x " + side + " mm, "));
  }
  check_refusal(run_with_cache("hapt bake t.off --unit any", folder.path()),
                "--size, which is missing");
  check_refusal(run_with_cache("hapt bake t.off --unit furlong", folder.path()),
                "known here: m, mm, cm, in, any, or a length as");
}

}  // namespace haptic
