// SPDX-License-Identifier: GPL-3.0-or-later
// The command line tool as people and scripts use it, on the real binaries.
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>

#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::HapticdProcess;
using test::programs_are_built;
using test::TemporaryRuntimeFolder;
using test::Watcher;

struct Ran {
  int code = -1;
  std::string output;  // standard output and standard error
};

/// Runs `hapt` with these words through the shell, in the folder.
Ran hapt(const std::string& words, const std::string& folder) {
  const std::string program = (test::program_folder() / "hapt").string();
  const std::string line = "cd '" + folder + "' && '" + program + "' " + words + " 2>&1";
  Ran ran;
  FILE* pipe = popen(line.c_str(), "r");
  REQUIRE(pipe != nullptr);
  char text[4096];
  while (const size_t n = std::fread(text, 1, sizeof text, pipe)) ran.output.append(text, n);
  const int status = pclose(pipe);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return ran;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

size_t lines(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("hapt demo: the simulated hand touches, nothing is lost, exit 0") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const Ran ran =
      hapt("demo --config plane.toml --for 4 -o run.mcap --plot run.svg", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "SIMULATED hand, seed 1"));
  CHECK(has(ran.output, "samples lost                                    0"));
  CHECK(has(ran.output, "real-time"));
  CHECK(has(ran.output, "log: run.mcap"));
  CHECK(std::filesystem::file_size(folder.path() + "/run.svg") > 1000);

  // the log is a recorded hand as well: it plays back, open loop
  const Ran again = hapt("replay run.mcap --config plane.toml -o again.mcap --json", folder.path());
  INFO(again.output);
  CHECK(again.code == 0);
  CHECK(has(again.output, "\"metric\": \"samples lost\", \"value\": 0, "));
  const Ran table = hapt("export again.mcap --csv -o again.csv", folder.path());
  CHECK(table.code == 0);
  CHECK(std::filesystem::file_size(folder.path() + "/again.csv") > 100000);
}

TEST_CASE("hapt demo: a hand that touches nothing is no success") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  std::ofstream(folder.path() + "/free.toml") << R"([session]
name = "free"
[device]
kind = "simulated-hand"
)";
  const Ran ran = hapt("demo --config free.toml --for 0.5 -o free.mcap --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 1);
  CHECK(has(ran.output, "\"metric\": \"ticks in contact\", \"value\": 0, "));
}

TEST_CASE("hapt: what cannot start says so in one line and exits with 1") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const std::string words =
      GENERATE(as<std::string>(), "demo --config missing.toml", "top -n 1", "record -o x.mcap",
               "export missing.mcap", "replay missing.csv --config lever.toml",
               "eval --config missing.toml");
  const Ran ran = hapt(words, folder.path());
  CAPTURE(words, ran.output);
  CHECK(ran.code == 1);
  CHECK(lines(ran.output) == 1);
  CHECK(ran.output.rfind("hapt: ", 0) == 0);
}

TEST_CASE("hapt top: shows the three processes of a running session") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  const std::string config = std::string(HAPTIC_SOURCE_DIR) + "/configs/plane.toml";
  HapticdProcess hapticd({config, "--session", "top"}, folder.path());
  Watcher watcher("top");
  REQUIRE(watcher.wait_for_all());
  const Ran screen = hapt("top --session top -b -n 2 -d 0.2", folder.path());
  INFO(screen.output);
  CHECK(screen.code == 0);
  for (const char* name : {"servo0", "contact0", "sim"}) CHECK(has(screen.output, name));
  CHECK(has(screen.output, "force"));
  const Ran json = hapt("top --session top -n 1 -d 0.2 --json", folder.path());
  CHECK(json.code == 0);
  CHECK(has(json.output, "{\"case\": \"servo0\", \"metric\": \"rate\", \"value\": "));
}

}  // namespace haptic
