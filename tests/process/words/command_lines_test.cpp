// SPDX-License-Identifier: GPL-3.0-or-later
// Command lines of `hapt` that start no session: what is refused, and how.
#include <sys/stat.h>

#include <fstream>
#include <string>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/log/trace.h"
#include "tests/process/hapt_command.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {

using namespace test;

namespace {

struct Refused {
  const char* words;
  int code;
  const char* says;
};

const std::vector<Refused> kRefused{
    // what cannot start: 2 if a file is wrong, else 1
    {"demo --config missing.toml", 2, ""},
    {"top -n 1", 1, ""},
    {"record -o x.mcap", 1, ""},
    {"export missing.mcap", 2, ""},
    {"replay missing.csv --config lever.toml", 2, ""},
    {"eval --config missing.toml", 2, ""},
    {"demo --plot /nowhere/x.svg", 1, ""},
    {"replay . -o x.mcap", 2, ""},
    {"demo -o /nowhere/x.mcap", 1, ""},
    {"record -o /", 1, ""},
    // what is typed wrongly
    {"bogus", 2, "hapt: there is no command 'bogus'; see hapt --help"},
    {"", 2, "hapt: a command is missing; see hapt --help"},
    {"demo --for abc", 2, "known units: s, ms, us, µs, min, h; see hapt demo --help"},
    {"demo --for nan", 2, "\"nan\" is not a finite number"},
    {"eval --for -1", 2, "--for: is out of range (\"-1\")"},
    {"record -o x --for 0", 2, "--for: is out of range (\"0\")"},
    {"top -n -1", 2, "-1"},
    {"top -d 1e9", 2, "is out of range (\"1e9\")"},
    {"demo --bogus", 2, "there is no option '--bogus'; see hapt demo --help"},
    {"demo --out x", 2, "there is no option '--out'; did you mean '--output'?"},
    {"demmo", 2, "there is no command 'demmo'; did you mean 'demo'?"},
    {"help demmo", 2, "there is no command 'demmo'; did you mean 'demo'?"},
    {"bench jiter", 2, "there is no command 'jiter'; did you mean 'jitter'?"},
    {"demo bunny peg", 2, "'peg' is one word too many; see hapt demo --help"},
    {"demo --for", 2, "--for needs a value; see hapt demo --help"},
    {"bake x.off --band 1mm", 2, "--band requires --voxel; add it"},
    {"demo peg --config x.toml", 2, "--config excludes SCENE; leave one out"},
    {"top -n x", 2, "-n: is 'x'; write a whole number"},
    {"demo --plot x.png", 2,
     "--plot: the drawing is an SVG; name it with .svg at the end; see hapt demo --help"},
    {"export", 2, "RECORDING is missing"},
    // what would overwrite a recording, refused by name, before anything is read
    {"export hand.mcap -o hand.mcap", 1, "is read and would be overwritten"},
    {"export hand.mcap -o hand.mcap --overwrite", 1, "is read and would be overwritten"},
    {"export hand.mcap -o ./hand.csv", 1, "exists; choose another name or add --overwrite"},
    {"replay hand.mcap --config plane.toml -o hand.mcap --overwrite", 1, "is read and would"},
    {"replay hand.csv --config plane.toml -o hand.mcap", 1, "exists; choose another name"},
    {"demo --config plane.toml -o hand.mcap", 1, "exists; choose another name"},
    {"demo --config plane.toml -o new.svg --plot new.svg", 1, "is to be written twice"},
    {"demo --config plane.toml -o new.mcap --plot old.svg", 1, "exists; choose another name"},
    {"eval --config plane.toml --for 1 --plot old.svg", 1, "exists; choose another name"},
    {"record -o hand.mcap", 1, "exists; choose another name"},
};

}  // namespace

TEST_CASE("hapt: what cannot start, is typed wrongly or would overwrite is refused in one line") {
  const TemporaryRuntimeFolder folder;
  const auto contents = [&] {
    std::string all;
    for (const char* name : {"/hand.csv", "/hand.mcap", "/old.svg"}) {
      std::ifstream file(folder.path() + name);
      all.append(std::istreambuf_iterator<char>(file), {});
    }
    return all;
  };
  std::ofstream(folder.path() + "/hand.csv") << "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n";
  std::ofstream(folder.path() + "/hand.mcap") << "an old recording";
  std::ofstream(folder.path() + "/old.svg") << "an old plot";
  const std::string before = contents();
  for (const Refused& refused : kRefused) {
    const Ran ran = hapt(refused.words, folder.path());
    CAPTURE(refused.words, ran.output);
    CHECK(ran.code == refused.code);
    CHECK(lines(ran.output) == 1);
    CHECK(ran.output.rfind("hapt: ", 0) == 0);
    CHECK(has(ran.output, refused.says));
    CHECK(contents() == before);
  }
}

TEST_CASE("hapt: half a table on a full device is a failure") {
  const TemporaryRuntimeFolder folder;
  TraceWriter trace(folder.path() + "/run.mcap", {});
  for (int64_t t_ns = 0; t_ns < 500; ++t_ns) {
    ServoFrame frame{};
    frame.t_ns = t_ns;
    trace.write(servo_topic(kFirstHand), frame, {t_ns, t_ns, 0});
  }
  REQUIRE(trace.close());
  for (const std::string words :
       {"export run.mcap >/dev/full", "export run.mcap >&-",
        "eval --config plane.toml --for 1 --json >/dev/full", "--version >/dev/full"}) {
    const Ran ran = hapt(words, folder.path());
    CAPTURE(words, ran.output);
    CHECK(ran.code == 1);
    CHECK(has(ran.output, "hapt: standard output cannot be written"));
  }
}

TEST_CASE("hapt: a pipe, a device or a folder in the place of a file is refused in one line") {
  const TemporaryRuntimeFolder folder;
  REQUIRE(mkfifo((folder.path() + "/pipe").c_str(), 0600) == 0);
  for (const std::string words :
       {"hapt export pipe", "hapt export /dev/zero", "hapt export .", "hapt demo --config pipe",
        "hapt demo --config /dev/zero", "hapt replay pipe --config plane.toml", "hapticd pipe",
        "hapticd /dev/zero"}) {
    const Ran ran = shell("timeout 20 " + words, folder.path());
    CAPTURE(words, ran.output);
    CHECK((ran.code == 1 || ran.code == 2));
    CHECK(lines(ran.output) == 1);
    CHECK((has(ran.output, "is a pipe") || has(ran.output, "is a device") ||
           has(ran.output, "is a folder")));
  }
}

TEST_CASE("hapt eval: the chain on virtual time holds and repeats") {
  const TemporaryRuntimeFolder folder;
  const Ran ran = hapt("eval --config plane.toml --for 4 --json --plot eval.svg", folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(figure(ran.output, "repeats that differ, of 1") == 0);
  CHECK(figure(ran.output, "ticks") == 4000);
  CHECK(figure(ran.output, "ticks in contact") > 100);
  CHECK(std::filesystem::file_size(folder.path() + "/eval.svg") > 1000);
}

TEST_CASE("hapt wire: docs/wire.md is what it prints") {
  const TemporaryFolder folder;
  const Ran ran = hapt("wire", folder.path());
  REQUIRE(ran.code == 0);
  std::ifstream file(from_source("docs/wire.md"));
  const std::string page(std::istreambuf_iterator<char>(file), {});
  INFO("a record has changed: build/dev/bin/hapt wire > docs/wire.md");
  CHECK((page == ran.output));
}

TEST_CASE("hapt wire: says which fields are lists, and how long they may be") {
  const TemporaryFolder folder;
  const std::string page = hapt("wire", folder.path()).output;
  CHECK(has(page, "`contacts` | Contact[≤ 64] |"));
  CHECK(has(page, "`pushes` | ObjectPush[≤ 64] |"));
  CHECK(has(page, "`K` | double[36] |"));
  CHECK(has(hapt("wire --json", folder.path()).output, "\"is_part\": true"));
}

}  // namespace haptic
