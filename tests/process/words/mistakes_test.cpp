// SPDX-License-Identifier: GPL-3.0-or-later
// The mistakes that people make, each with the line and the exit code it gets: what is wrong,
// where, and how to mend it. And the help texts of all programs.
#include <fstream>
#include <regex>
#include <sstream>
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

/// A line of the shell, its exit code, and the line it must print; * stands for anything. `among`:
/// the program prints other lines too.
struct Mistake {
  const char* line;
  int code;
  const char* says;
  bool among = false;
};

/// `with S` edits plane.toml by a sed script, into bad.toml.
const std::vector<Mistake> kInSessionFiles{
    {"with s/stiffness/stifness/; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:14:1: unknown key 'stifness' in [coupling]; did you mean 'stiffness'?"},
    {"with s/stiffness/stifness/; hapt demo --config bad.toml", 2,
     "hapt: bad.toml:14:1: unknown key 'stifness' in [coupling]; did you mean 'stiffness'?"},
    {"with s/coupling/couplin/; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:*: unknown key 'couplin' in the file; did you mean 'coupling'?"},
    {"hapticd --check-config plane.toml --renderer godobject3", 2,
     "hapticd: there is no renderer 'godobject3'; did you mean 'god-object3'?"},
    {"with s/simulated-hand/omega/; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:7:8: 'kind' is 'omega'; known here: simulated-hand, simulated-arm, "
     "replay, woodenhaptics, six-motors, own-device, falcon, woodenhaptics-hid, spacemouse, "
     "polhem, haply-2dof (other "
     "hardware needs a driver: docs/adding.md)"},
    {"with 's:\"800 N/m\":800:'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:14:13: 'stiffness' needs a unit; write for example \"800 N/m\"; known "
     "units: N/m, N/mm, kN/m"},
    {"with 's:800 N/m:6 mm:'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:14:13: 'stiffness' \"6 mm\" is a length, not a stiffness; write for "
     "example "
     "\"800 N/m\"; known units: N/m, N/mm, kN/m"},
    {"with 's:800 N/m:8 lbf:'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:14:13: 'stiffness' \"8 lbf\" has an unknown unit; write for example \"800 "
     "N/m\"; known units: N/m, N/mm, kN/m"},
    {"with 's:800 N/m:80,5 N/m:'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:14:13: 'stiffness' \"80,5 N/m\" has a comma; the decimal sign is a point, "
     "as in 8.5; write for example \"800 N/m\"; known units: N/m, N/mm, kN/m"},
    {"with '$a [servo]\\nrate = \"20 kHz\"'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:*: 'rate' is out of range (\"20 kHz\"); it must lie between 100 Hz and "
     "10000 Hz"},
    {"mesh none.off; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:*: 'mesh' was not found; looked for */none.off, *; fetch the example "
     "meshes with `./run meshes`, or set HAPTICD_MESHES to the folder of yours"},
    {"mesh cube.off any; sed /size/d bad.toml >less.toml; hapticd --check-config less.toml", 2,
     "hapticd: less.toml:*: [[object]] has no 'size'; *"},
    {"mesh cube.off m; hapticd bad.toml", 2,
     "* error contact0: */cube.off: states size 80 mm but the file at unit 'm' is "
     "80000 mm: correct unit or size, or unit = \"any\" to scale",
     true},
    {"with '/\"plane\"/a renderer = \"voxel\"'; hapticd --check-config bad.toml", 2,
     "hapticd: bad.toml:*[tool]*"},
    {"device woodenhaptics /dev/ttyACM77; hapticd bad.toml", 2,
     "*/dev/ttyACM77: cannot be opened: No such file or directory; plug the device in and switch "
     "it on, or correct 'path' in [device.serial]"},
    {"device woodenhaptics $PWD/plane.toml; hapticd bad.toml", 2,
     "*/plane.toml: is no serial node: *; check 'path' in [device.serial]"},
    {"touch node; chmod 0 node; device woodenhaptics $PWD/node; unprivileged hapticd bad.toml", 2,
     "*/node: cannot be opened: Permission denied; add the user to the group that owns it (ls -l "
     "shows it) and log in again"},
    {"printf 'a: 1\\n' >bad.toml; hapticd bad.toml", 2, "hapticd: bad.toml:1:*: not TOML: *"},
    {"{ printf '\\357\\273\\277'; cat plane.toml; } >bom.toml; hapticd --check-config bom.toml", 0,
     "bom.toml: ok, session 'plane', 1 object"},
    {"hapticd .", 2, "hapticd: .: is a folder*"},
    {"hapticd none.toml", 2, "hapticd: none.toml: no such session file; looked at none.toml, *"},
    {"hapticd plan", 2, "hapticd: plan: no such session file; looked at *did you mean 'plane'?"},
    {"hapt demo --config rigidpeg", 2, "hapt: rigidpeg: no such *; did you mean 'rigid-peg'?"},
    {"mkdir -p peg; hapticd --check-config peg", 0, "*peg-in-hole.toml: ok, session *", true},
    {"cd /; hapticd --check-config plane", 0, "*plane.toml: ok, session 'plane', 1 object"},
    {"sed 's/$/\\r/' plane.toml >crlf.toml; hapticd --check-config crlf.toml", 0,
     "crlf.toml: ok, session 'plane', 1 object"},
    {"cp $SOURCE/configs/lever.toml .; hapticd lever.toml", 2,
     "*lever.csv: cannot be read (No such file or directory); *", true},
};

/// `run_until WORD` ends a session of plane.toml when its log has the word, and prints that log.
const std::vector<Mistake> kWithoutRights{
    {"ulimit -r 0; run_until 'servo0: started' unprivileged", 0,
     "* servo0: started: *; not real-time here: refused SCHED_FIFO (Operation not permitted)*; "
     "*/etc/security/limits.d/*",
     true},
};

const std::vector<Mistake> kInMeshes{
    {"hapt bake inverted.off --unit mm", 0, "*turned*", true},
    {"hapt bake open.off --unit mm", 2,
     "hapt: *open.off is not closed: 4 border edges, first near (*) mm; close the mesh, or add "
     "--allow-open (in a session file: open = true) to use it as a one-sided surface"},
    {"hapt demo --mesh open.off --unit mm", 2,
     "hapt: *open.off is not closed: *; close the mesh, or add --allow-open (in a session file: *"},
    {"hapt bake tab.stl --unit mm", 2, "hapt: *tab.stl is not closed: 3 border edges, *"},
    {"hapt bake cube.off --unit m", 0,
     "  warning: it is 80 m long; was unit \"m\" meant as \"mm\"?", true},
    {"hapt bake cube.off --unit mm", 0,
     "cube.off: 12 triangles, 8 vertices, 80 x 80 x 80 mm, closed; *", true},
    {"hapt bake cube.off --size '80 mm' --unit m", 2,
     "hapt: cube.off: states size 80 mm but the file at unit 'm' is 80000 mm: correct unit or "
     "size, or unit = \"any\" to scale"},
    {"hapt bake bunny.off", 2, "hapt: bunny.off: cannot be read (No such file or directory)*"},
};

const std::vector<Mistake> kInRecordings{
    {"hapt export plane.toml", 2,
     "hapt: plane.toml: is not an MCAP file; recordings are made by `hapt record`"},
    {"hapt clearance plane.toml", 2,
     "hapt: plane.toml: is not an MCAP file; recordings are made by `hapt record`"},
    {"hapt clearance x.mcap --svg x.png", 2,
     "hapt: --svg: the drawing is an SVG; name it with .svg at the end; see hapt clearance --help"},
    {"hapt replay hand.csv --config plane.toml", 2,
     "hapt: hand.csv: cannot be read (No such file or directory); name a recording (.mcap or "
     ".csv)"},
    {"printf 'time,x,y,z\\n0,0,0,0\\n' >h.csv; hapt replay h.csv", 2,
     "h.csv has no session file inside: playing bunny.toml; --config *", true},
    {"printf 'time,x,y,z\\n0,0,0,0\\n' >h.csv; hapt replay h.csv --config plane.toml", 2,
     "hapt: h.csv:1: has no column 't_s'; it has time, x, y, z; rename or add the column"},
    {"printf 't_s;x_m;y_m;z_m\\n0;0;0;0\\n' >h.csv; hapt replay h.csv --config plane.toml", 2,
     "hapt: h.csv:1: its columns are separated by semicolons; save it with commas, and with points "
     "in the numbers"},
    {"printf 't_s,x_m,y_m,z_m\\n0,0,0,0\\n1,0,abc,0\\n' >h.csv; "
     "hapt replay h.csv --config plane.toml",
     2, "hapt: h.csv:3: 'y_m' is 'abc', not a finite number; mend or remove the line"},
    {"touch x.mcap; hapt demo --config plane.toml -o x.mcap", 1,
     "hapt: x.mcap: exists; choose another name or add --overwrite"},
    {"hapt demo --config plane.toml -o nowhere/x.mcap", 1,
     "hapt: nowhere/x.mcap: cannot be written (No such file or directory); check the folder and "
     "its rights"},
};

const std::vector<Mistake> kOnCommandLines{
    {"hapt demo --list", 0, "hapt demo bunny          the Stanford bunny", true},
    {"hapt demo --list | tail -n 1", 0, "hapt demo --mesh part.stl --unit mm *"},
    {"hapt bench jitter --pairs 1 --for 1 --core 900", 1,
     "hapt: bench jitter: this process may not use core 900; choose another*"},
    {"hapt bench jitter --for 0.4", 2, "hapt: *"},
    {"hapt torture --minutes never", 2, "hapt: --minutes: *"},
    {"hapt torture -o /no/such/folder/x.mcap", 1, "hapt: /no/such/folder/x.mcap: *"},
    {"hapticd --bogus x plane.toml", 2,
     "hapticd: there is no option '--bogus'; see hapticd --help"},
    {"hapticd", 2, "hapticd: CONFIG.toml is missing; see hapticd --help"},
    {"hapticd plane.toml --session", 2, "hapticd: --session needs a value; see hapticd --help"},
    {"haptic-emulator --hand iron", 2,
     "haptic-emulator: --hand: is 'iron'; known here: none, light-grip, typical, firm, stiff-arm; "
     "see haptic-emulator --help"},
    {"haptic-servo", 2,
     "haptic-servo: started by hapticd with *; start 'hapticd CONFIG.toml' instead"},
    {"alone HAPTICD_SOURCE=$SOURCE eval", 1,
     "hapt: */alone/hapt-lab: cannot be started (No such file or directory); `./run build` builds "
     "it"},
    {"alone A=1 bench ring", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 bench --help", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 --help eval", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 selftest", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 torture", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 zwidth", 1, "hapt: */alone/hapt-lab: cannot be started*"},
    {"alone A=1 --help | grep -c -e torture -e bake", 0, "1*"},
    {"alone A=1 bake --help", 0, "Usage: hapt bake*", true},
    {"alone HAPTICD_SOURCE=$SOURCE view", 1,
     "hapt: */alone/haptic-view: cannot be started (No such file or directory); `./run demo "
     "--view` builds it, as does `./run build`"},
    {"alone HAPTICD_SOURCE=$SOURCE help view", 1,
     "hapt: */alone/haptic-view: *`./run demo --view`*"},
    {"alone HAPTICD_SOURCE=$SOURCE demo --view --config $PWD/plane.toml", 1,
     "hapt: */alone/haptic-view: *`./run demo --view`*"},
    {"alone A=1 view", 1,
     "hapt: */alone/haptic-view: *; it belongs to the package hapticd; install that again"},
    {"alone HAPTICD_LIBEXEC=$PWD/alone demo --config $PWD/plane.toml", 1,
     "hapt: */alone/hapticd: *; HAPTICD_LIBEXEC has to name the folder of all programs"},
    {"hapt demo --config far.toml --for 1 -o far.mcap", 1,
     "FAILED: the object 'block' lies 4.9 m beyond what the hand reaches; move it to position = *",
     true},
    {"HAPTICD_RUNTIME_DIR=/proc/none hapticd plane.toml", 1,
     "hapticd: cannot create the runtime folder /proc/none (set HAPTICD_RUNTIME_DIR to a folder "
     "you may write): *"},
};

/// What a person can read is shown as it is.
const std::vector<Mistake> kWithNames{
    {"hapt bake 'Schädel 頭蓋骨.stl'", 2, "hapt: Schädel 頭蓋骨.stl*"},
    {"hapticd 'Schädel 頭蓋骨.stl'", 2, "hapticd: Schädel 頭蓋骨.stl*"},
    {"hapt export 'Schädel 頭蓋骨.stl'", 2, "hapt: Schädel 頭蓋骨.stl*"},
    {"hapt demo --config 'Schädel 頭蓋骨.stl'", 2, "hapt: Schädel 頭蓋骨.stl*"},
};

const std::vector<Mistake> kWithoutSession{
    {"hapt status", 1,
     "hapt: no session is running (looked in *; HAPTICD_RUNTIME_DIR names another folder); start "
     "one: hapticd CONFIG.toml"},
    {"hapt arm --wait 200ms", 1, "hapt: no session is running (looked in *; start one: *"},
    {"hapt pause --wait soon", 2, "hapt: --wait: *"},
    {"hapt top --session bunny", 1,
     "hapt: no session 'bunny' is running (looked in *; HAPTICD_RUNTIME_DIR names another folder); "
     "start one: hapticd CONFIG.toml --session bunny"},
};

const std::vector<Mistake> kWithTwoSessions{
    {"hapt status", 1,
     "hapt: several sessions are running (one, two); choose one, as --session one"},
    {"hapt stop --session three", 1,
     "hapt: no session 'three' is running (looked in *; running: one, two); start one: hapticd "
     "CONFIG.toml --session three"},
    {"hapticd plane.toml --session one", 1,
     "hapticd: session 'one' runs already (hapticd, pid *); end it with 'hapt stop --session one' "
     "or start this one with --session OTHER"},
    {"mkdir -m 700 other; HAPTICD_RUNTIME_DIR=$PWD/other hapt status", 1,
     "hapt: no session is running (looked in */other; HAPTICD_RUNTIME_DIR names another folder); "
     "start one: hapticd CONFIG.toml"},
    {"hapt arm --wait 30s", 1,
     "hapt: several sessions are running (one, two); choose one, as --session one"},
    {"hapt set renderer voxel --session one", 2, "hapt: renderer: 'voxel' *add [tool] to its file"},
    {"hapt set renderer godobject3 --session one", 2,
     "hapt: there is no renderer 'godobject3'; did you mean 'god-object3'?"},
    {"hapt set stiffnes '500 N/m' --session one", 2,
     "hapt: cannot set 'stiffnes'; did you mean 'stiffness'?"},
    {"hapt set stiffness 500 --session one", 2,
     "hapt: stiffness: \"500\" needs a unit; write for example \"800 N/m\"; known units: N/m, "
     "N/mm, "
     "kN/m"},
    {"kill -9 $(pid_of contact0 one); until hapt top -n 1 --session one | grep '^contact0 *run *2 "
     "'; "
     "do :; done",
     0, "contact0 *run *2 *"},
};

constexpr const char* kShellFunctions = R"sh(
with() { sed -e "$@" plane.toml >bad.toml; }
mesh() { sed '/^primitive/,$d' plane.toml >bad.toml
  printf 'mesh = "%s"\nunit = "%s"\nsize = "80 mm"\n' "$1" "${2:-mm}" >>bad.toml; }
device() { sed "s:simulated-hand:$1:; /hand.intent/,/press/d" plane.toml >bad.toml
  printf '[device.serial]\npath = "%s"\n' "$2" >>bad.toml; }
unprivileged() {
  if [ "$(id -u)" = 0 ]; then setpriv --inh-caps=-all --bounding-set=-all "$@"; else "$@"; fi; }
run_until() { word=$1; shift
  "$@" hapticd plane.toml 2>log & until grep -q "$word" log || ! kill -0 $!; do sleep 0.1; done
  hapt stop >/dev/null; wait $!; code=$?; cat log; return $code; }
alone() { mkdir -p alone; cp -u "$(command -v hapt)" alone; set=$1; shift
  env "$set" alone/hapt "$@"; }
pid_of() { hapt status --json --session "$2" | grep -o "\"$1\", \"pid\": [0-9]*" | sed 's/.* //'; }
)sh";

void prepare_mistakes(const std::string& folder) {
  std::filesystem::copy(test::from_source("configs/plane.toml"), folder + "/plane.toml");
  const std::string corners =
      "0 0 0\n80 0 0\n80 80 0\n0 80 0\n0 0 80\n80 0 80\n80 80 80\n0 80 80\n";
  const std::string outward = "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  const std::string inward = "4 0 1 2 3\n4 4 7 6 5\n4 0 4 5 1\n4 1 5 6 2\n4 2 6 7 3\n4 3 7 4 0\n";
  std::ofstream(folder + "/cube.off") << "OFF\n8 6 0\n" << corners << outward;
  std::ofstream(folder + "/inverted.off") << "OFF\n8 6 0\n" << corners << inward;
  std::ofstream(folder + "/open.off") << "OFF\n8 5 0\n" << corners << outward.substr(10);
  std::ofstream(folder + "/tab.stl")
      << "solid\tplate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 80 0 0\nvertex 0 80 "
         "0\nendloop\nendfacet\nendsolid\tplate\n";
  std::ofstream(folder + "/far.toml")
      << "[session]\nname = \"far\"\n[device]\nkind = \"simulated-hand\"\n[[object]]\nname = "
         "\"block\"\nprimitive = \"sphere\"\nsize = \"10 mm\"\nposition = [\"5 m\", \"0 m\", \"0 "
         "m\"]\n";
}

bool is_like(const std::string& line, const std::string& pattern) {
  size_t at = 0;
  std::istringstream parts(pattern);
  bool is_first = true;
  for (std::string part; std::getline(parts, part, '*'); is_first = false) {
    const size_t found = line.find(part, at);
    if (found == std::string::npos || (is_first && found != 0)) return false;
    at = found + part.size();
  }
  return pattern.back() == '*' || at == line.size();
}

void check(const std::vector<Mistake>& mistakes, const std::string& folder) {
  for (const Mistake& mistake : mistakes) {
    const Ran ran = test::shell("export HAPTICD_CACHE=$PWD/cache SOURCE=" + test::from_source("") +
                                    kShellFunctions + std::string(mistake.line),
                                folder);
    CAPTURE(mistake.line, mistake.says, ran.output);
    CHECK(ran.code == mistake.code);
    CHECK(test::problem_of_message(ran.output) == "");
    std::istringstream output(ran.output);
    size_t alike = 0, all = 0;
    for (std::string line; std::getline(output, line); ++all) alike += is_like(line, mistake.says);
    CHECK(alike == 1);
    if (!mistake.among) CHECK(all == 1);
  }
}

}  // namespace

TEST_CASE("mistakes: in a session file, a mesh, a recording and on a command line") {
  const test::TemporaryRuntimeFolder folder;
  prepare_mistakes(folder.path());
  check(GENERATE(kInSessionFiles, kInMeshes, kInRecordings, kOnCommandLines, kWithNames,
                 kWithoutSession, kWithoutRights),
        folder.path());
}

TEST_CASE("mistakes: about the session that is meant") {
  const test::TemporaryRuntimeFolder folder;
  prepare_mistakes(folder.path());
  const std::string config = test::write_quiet_config(folder.path());
  test::HapticdProcess one({config, "--session", "one"}, folder.path());
  test::Watcher first("one");
  REQUIRE(first.wait_for_all());
  test::HapticdProcess two({config, "--session", "two"}, folder.path());
  test::Watcher second("two");
  REQUIRE(second.wait_for_all());
  check(kWithTwoSessions, folder.path());
}

TEST_CASE("help: every program and command has an example, in lines of at most 80 columns") {
  const test::TemporaryRuntimeFolder folder;
  std::vector<std::string> pages{"hapticd", "haptic-emulator", "hapt"};
  for (const std::string& page : pages) {
    CHECK(has(test::shell(page + " --help", folder.path()).output, "Exit codes: 0 fine; 1 "));
  }
  for (const std::string command : {"hapt", "hapt bench"}) {
    const std::string help = test::shell(command + " --help", folder.path()).output;
    std::istringstream lines(help.substr(help.find("Commands:")));
    for (std::string line; std::getline(lines, line) && !line.empty();) {
      if (line.size() > 3 && line.starts_with("  ") && line[2] != ' ') {
        pages.push_back(command + " " + line.substr(2, line.find(' ', 2) - 2));
      }
    }
  }
  CHECK(pages.size() > 30);
  for (const std::string& page : pages) {
    const Ran ran = test::shell(page + " --help", folder.path());
    CAPTURE(page, ran.output);
    CHECK(ran.code == 0);
    CHECK(has(ran.output, "\nUsage: " + page));
    CHECK(has(ran.output, "\nExample:\n  " + page.substr(0, page.find(' '))));
    for (const std::string noise : {"ENUM", "TEXT", "INT", "FLOAT", "{", "->", " in ["}) {
      CAPTURE(noise);
      CHECK_FALSE(has(ran.output, noise));
    }
    std::istringstream lines(ran.output);
    for (std::string line; std::getline(lines, line);) CHECK(test::length(line) <= 80);
  }
  CHECK(test::shell("hapt help bench jitter", folder.path()).output ==
        test::shell("hapt bench jitter --help", folder.path()).output);
  CHECK(test::shell("hapt help", folder.path()).output ==
        test::shell("hapt --help", folder.path()).output);
}

TEST_CASE("version: every program says its name, release and commit") {
  const test::TemporaryRuntimeFolder folder;
  for (const std::string program : {"hapt", "hapticd", "haptic-emulator", "haptic-servo",
                                    "haptic-contact", "haptic-sim", "haptic-lockstep"}) {
    for (const std::string word : {"--version", "-V"}) {
      const Ran ran = test::shell(program + " " + word, folder.path());
      CAPTURE(ran.output);
      CHECK(ran.code == 0);
      CHECK(std::regex_match(ran.output, std::regex(program + " [0-9.]+ \\(.+\\)\n")));
    }
  }
}

}  // namespace haptic
