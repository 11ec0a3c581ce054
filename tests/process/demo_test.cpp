// SPDX-License-Identifier: GPL-3.0-or-later
// `hapt demo` as a newcomer sees it, of a mesh of one's own too, on the real binaries.
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

}  // namespace

TEST_CASE("hapt demo: what a newcomer sees fits a screen, and its last line says how it went") {
  const TemporaryRuntimeFolder folder;
  // the default scene of a checkout, and of an installed program
  const std::string scene = GENERATE(as<std::string>(), "bunny", "peg");
  if (scene == "bunny" && !test::find_mesh("bunny00.off")) return;
  // a line of how it goes comes after five seconds; one scene is enough to see it
  const bool is_long = scene == "bunny" || !test::find_mesh("bunny00.off");
  const std::string seconds = is_long ? "6" : "2";
  const Ran ran = hapt("demo " + scene + " --for " + seconds, folder.path());
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
  CHECK(said.rfind("passed: " + seconds + " s with ", 0) == 0);
  CHECK(has(said, " % in contact; next: hapt demo --list"));
  if (!is_long) return;
  // of the last five seconds, not of an instant
  const size_t share = ran.output.find(" % in contact   force up to ");
  REQUIRE(share != std::string::npos);
  CHECK(has(ran.output.substr(0, share), " of 6 s   "));
  CHECK(std::stoi(ran.output.substr(share - 3, 3)) >= 20);
  CHECK(std::stod(ran.output.substr(share + 28)) > 0.5);
}

TEST_CASE("hapt demo --mesh: a part of one's own is touched, as large as its file says") {
  const TemporaryRuntimeFolder folder;
  // a box of 6 x 5 x 4 mm, not about its middle
  std::ofstream(folder.path() + "/small part.off")
      << "OFF\n8 6 0\n10 10 10\n16 10 10\n16 15 10\n10 15 10\n10 10 14\n16 10 14\n16 15 14\n"
         "10 15 14\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  const Ran ran = hapt("demo --mesh 'small part.off' --unit mm --for 2 -o run.mcap", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(last_line(ran.output).rfind("passed: 2 s with small part.off", 0) == 0);
}

TEST_CASE("configs/lever.toml: its recording is there, and plays") {
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("demo --config lever.toml --for 0.5 -o lever.mcap --json", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "share of ticks in contact") > 30);
  // in lockstep to its end
  const Ran all = hapt("eval --config lever.toml --json", folder.path());
  INFO(all.output);
  CHECK(all.code == 0);
  CHECK(figure(all.output, "ticks") == 8001);
  CHECK(figure(all.output, "share of ticks in contact") > 30);
}

}  // namespace haptic
