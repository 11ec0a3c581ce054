// SPDX-License-Identifier: GPL-3.0-or-later
// Names and values that would colour, clear or flood a terminal, in every program and on the
// control socket: the output is whole lines of printable text of limited length.
#include <fstream>
#include <string>
#include <vector>

#include "proto/ipc/control_socket.h"
#include "tests/process/hapt_command.h"
#include "tests/process/programs.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

// @ stands for the hostile word
const std::vector<std::string> kLines{
    "hapt @",
    "hapt --@",
    "hapt demo --config @",
    "hapt demo @",
    "hapt demo --config plane.toml --session @ --for 1",
    "hapt demo --config plane.toml --trace @ --for 1",
    "hapt demo --config plane.toml -o @/x.mcap --for 1",
    "hapt demo --config plane.toml --plot @/x --for 1",
    "hapt replay @",
    "hapt top --session @",
    "hapt top -d @",
    "hapt record -o x.mcap --session @",
    "hapt record -o @/x.mcap",
    "hapt record -o x.mcap --config @",
    "hapt export @",
    "hapt export --topic @ missing.mcap",
    "hapt eval --config @",
    "hapt eval mesh @.off",
    "hapt eval mesh @",
    "hapt eval mesh flat:2 --renderer @",
    "hapt eval ruffaldi --surface @",
    "hapt eval compare @",
    "hapt bake @",
    "hapt bake @.off",
    "hapt bake t.off --unit @",
    "hapt bench @",
    "hapt bench point-proxy --mesh @",
    "hapt selftest --config @",
    "hapt torture -o @/x.mcap",
    "hapt status --session @",
    "hapt stop --session @",
    "hapt set @ 1",
    "hapt set stiffness @ --session @",
    "HAPTICD_RUNTIME_DIR=/proc/@ hapt status",
    "HAPTICD_RUNTIME_DIR=/proc/@ hapticd plane.toml",
    "HAPTICD_LIBEXEC=@ hapticd plane.toml",
    "HAPTICD_LIBEXEC=@ hapt demo --config plane.toml --for 1 -o l.mcap",
    "HAPTICD_CONFIGS=@ hapt demo --config missing.toml",
    "HAPTICD_MESHES=@ hapticd --check-config mesh.toml",
    "hapticd @",
    "hapticd --@ plane.toml",
    "hapticd --check-config @",
    "hapticd plane.toml --session @",
    "hapticd plane.toml --replay @",
    "haptic-servo @",
    "haptic-contact --config-fd @",
    "haptic-sim --config-fd 0 --control-fd 0 --generation @",
    "bash -c 'exec -a \"$0\" haptic-sim' @",
    "haptic-lockstep @",
    "haptic-lockstep plane.toml --renderer @",
    "haptic-emulator --hand @",
    "haptic-emulator --@",
    "haptic-emulator --link @/x/y",
    "haptic-emulator --log @/x/y",
    "haptic-emulator --hover @",
    "01_watch @",
    "02_draw @/x.svg",
    "02_draw x.svg @",
};

std::string with_word(std::string line, const std::string& hostile) {
  const std::string quoted = word(hostile);
  for (size_t at = 0; (at = line.find('@', at)) != std::string::npos; at += quoted.size()) {
    // inside a word of the shell, quotes only concatenate
    line.replace(at, 1, quoted);
  }
  return line;
}

void prepare(const std::string& folder) {
  std::filesystem::copy(test::from_source("configs/plane.toml"), folder + "/plane.toml");
  std::ofstream(folder + "/mesh.toml")
      << "[session]\nname = \"m\"\n[device]\nkind = \"simulated-hand\"\n[[object]]\nname = "
         "\"o\"\nmesh = \"none.off\"\nunit = \"m\"\nsize = \"1 m\"\n";
  std::ofstream(folder + "/t.off") << "OFF\n";
}

}  // namespace

TEST_CASE("messages: no word on a command line or in the environment reaches the terminal raw") {
  const test::TemporaryRuntimeFolder folder;
  prepare(folder.path());
  for (const std::string& line : kLines) {
    for (const std::string& hostile : kHostileTexts) {
      const Ran ran =
          shell("timeout 20 " + std::string(line.find('=') < line.find(' ') ? "env " : "") +
                    with_word(line, hostile),
                folder.path());
      CAPTURE(line, hostile, ran.output);
      CHECK(ran.code != 0);
      CHECK(ran.code != 124);
      CHECK_FALSE(ran.output.empty());
      CHECK(problem_of_message(ran.output) == "");
    }
  }
}

TEST_CASE("messages: what stands in a file reaches the terminal escaped and cut") {
  const test::TemporaryRuntimeFolder folder;
  const std::string head =
      "[session]\nname = \"x\"\n[device]\nkind = \"replay\"\n[device.replay]\npath = \"x.csv\"\n";
  // a basic string of TOML may hold any character as an escape
  const std::string escaped = "\\u001b[2J\\u009b31m\\n\\u202e\\u007f";
  const std::string longer(5000, 'A');
  struct File {
    std::string name, text, line;
  };
  std::vector<File> files;
  for (const std::string& foreign :
       {escaped, longer, std::string("\x1b[2J"), std::string("\xff")}) {
    const auto config = [&](const std::string& text) {
      files.push_back({"x.toml", text, "hapticd --check-config x.toml"});
    };
    config(head + "\"" + foreign + "\" = 1\n");
    config(head + "[\"" + foreign + "\"]\na = 1\n");
    config(head + "resampling = \"" + foreign + "\"\n");
    config(head + "max_gap = \"" + foreign + "\"\n");
    config(head + "max_gap = \"8 " + foreign + "\"\n");
    config("[session]\nname = \"" + foreign + "\"\n");
    config(head + "[[object]]\nname = \"o\"\nmesh = \"" + foreign + "\"\n");
    config(head + "[[object]]\nname = \"" + foreign + "\"\nprimitive = \"" + foreign + "\"\n");
    config(foreign + " = " + foreign + "\n" + foreign);
    // a trace and a mesh hold raw bytes
    const std::string raw = foreign == escaped ? "\x1b[2J\x7f\xc2\x9b" : foreign;
    for (const std::string& csv :
         {raw + ",b\n1,2\n", "t_s,x_m,y_m,z_m\n0,0,0,0\n1," + raw + ",0,0\n",
          "t_s,x_m,y_m,z_m," + raw + "\n0,0,0,0,0\n1,0,nan,0,0\n"}) {
      files.push_back({"x.csv", csv, "hapt replay x.csv --config plane.toml -o y.mcap"});
    }
    files.push_back({"x.mcap", "\x89MCAP0\r\n" + raw, "hapt export x.mcap"});
    files.push_back({"x.obj", "v " + raw + " 0 0\n", "hapt bake x.obj"});
    files.push_back({"x.obj", "v 0 0 0\nf " + raw + " 1 1\n", "hapt bake x.obj"});
    files.push_back({"x.off", "OFF\n" + raw + " 1 1\n", "hapt bake x.off"});
    files.push_back({"x.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty " + raw + " x\n",
                     "hapt bake x.ply"});
  }
  for (const File& file : files) {
    prepare(folder.path());
    std::ofstream(folder.path() + "/" + file.name, std::ios::binary) << file.text;
    const Ran ran = shell("timeout 20 " + file.line, folder.path());
    std::filesystem::remove(folder.path() + "/plane.toml");
    CAPTURE(file.text, file.line, ran.output);
    CHECK(ran.code != 0);
    CHECK(test::lines(ran.output) == 1);
    CHECK(problem_of_message(ran.output) == "");
  }
}

TEST_CASE("messages: the control socket answers in one printable line, and so does the log") {
  const test::TemporaryRuntimeFolder folder;
  const bool json = GENERATE(false, true);
  std::vector<std::string> words{write_quiet_config(folder.path()), "--session", "asked"};
  if (json) words.emplace_back("--log-json");
  test::HapticdProcess hapticd(words, folder.path());
  test::Watcher watcher("asked");
  REQUIRE(watcher.wait_for_all());
  for (const std::string& hostile : kHostileTexts) {
    for (const std::string& line :
         {hostile, "set " + hostile + " 1", "set stiffness " + hostile, "set time-scale " + hostile,
          "set stiffness 8 " + hostile, "set renderer " + hostile, "arm " + hostile,
          hostile + " arm", "set stiffness 500 N/m" + hostile}) {
      const std::string answer = say_to_session("asked", line);
      CAPTURE(line, answer);
      CHECK_THAT(answer, Catch::StartsWith("mistake: "));
      CHECK(problem_of_message(answer + "\n") == "");
    }
  }
  // a status is longer than a message, and complete
  CHECK_THAT(say_to_session("asked", "status"), Catch::StartsWith("{") && Catch::EndsWith("}"));
  CHECK(problem_of_message(hapticd.log()) == "");
}

TEST_CASE("messages: what a child of hapticd says is one printable line of its log") {
  const test::TemporaryRuntimeFolder folder;
  const test::Programs programs(folder.path());
  programs.replace("haptic-contact",
                   "printf 'haptic-contact: \\033[2J\\302\\2331m\\177 \\377 red\\r\\n' >&2\n"
                   "head -c 5000 /dev/zero | tr '\\0' A >&2\nexit 2");
  const std::string option = GENERATE(as<std::string>(), "", "--log-json");
  std::vector<std::string> words{write_quiet_config(folder.path()), "--session", "child"};
  if (!option.empty()) words.push_back(option);
  test::HapticdProcess hapticd(words, folder.path());
  CHECK(hapticd.exit_code() == 2);
  CAPTURE(hapticd.log());
  CHECK(hapticd.said("x1b[2J"));
  CHECK(hapticd.said("…(5000 bytes)…"));
  CHECK(problem_of_message(hapticd.log()) == "");
}

}  // namespace haptic
