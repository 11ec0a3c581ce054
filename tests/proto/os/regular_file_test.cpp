// SPDX-License-Identifier: GPL-3.0-or-later
// Every reader of whole files refuses other kinds in one line, without blocking.
#include "proto/os/regular_file.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/config/config.h"
#include "proto/config/read/height_image.h"
#include "proto/ipc/unix_socket.h"
#include "proto/log/csv.h"
#include "proto/log/hand_trace.h"
#include "proto/log/mcap.h"
#include "proto/log/trace.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

/// One of each kind that is not a regular file, and the expected message.
struct Kinds {
  test::TemporaryFolder folder;
  std::string pipe = folder.path() + "/pipe";
  UnixListener listener{folder.path() + "/socket", 0600};
  std::vector<std::pair<std::string, std::string>> all{{pipe, "is a pipe"},
                                                       {folder.path(), "is a folder"},
                                                       {"/dev/zero", "is a device"},
                                                       {"/dev/full", "is a device"},
                                                       {listener.path(), "is a socket"}};
  Kinds() { REQUIRE(mkfifo(pipe.c_str(), 0600) == 0); }
};

}  // namespace

TEST_CASE("files: a pipe, a device, a socket and a folder are no recording, config or table") {
  const Kinds kinds;
  const std::vector<std::function<void(const std::string&)>> readers{
      [](const std::string& path) { load_config(path); },
      [](const std::string& path) {
        ReplayConfig config;
        assign(config.path, path);
        load_hand_trace(config);
      },
      [](const std::string& path) { CsvReader reader(path); },
      [](const std::string& path) { McapReader reader(path); },
      [](const std::string& path) { read_height_image(path); }};
  for (const auto& [path, says] : kinds.all) {
    for (size_t i = 0; i < readers.size(); ++i) {
      const std::string error = test::refusal([&, &path = path] { readers[i](path); });
      CAPTURE(i, path, error);
      CHECK(error.starts_with(path));
      CHECK(error.find(says) != std::string::npos);
      CHECK(error.find('\n') == std::string::npos);
    }
  }
}

TEST_CASE("files: a recording is written to a file and to nothing else") {
  const Kinds kinds;
  auto all = kinds.all;
  all.emplace_back("/dev/null", "is a device");
  for (const auto& [path, says] : all) {
    const std::string error = test::refusal([&path = path] { TraceWriter(path, {}); });
    CAPTURE(path, error);
    CHECK(error == path + ": " + says + ", and a recording needs a file; name one (.mcap)");
  }
}

TEST_CASE("files: no more is read than is asked for, and what grows meanwhile is seen") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/text";
  std::ofstream(path) << std::string(4096, 'x');
  std::string text;
  CHECK(read_regular_file(path, 4096, text).empty());
  CHECK(text == std::string(4096, 'x'));
  CHECK(read_regular_file(path, 4095, text) == "has more than 3 KiB");
  // the kernel reports no size for files that it generates on reading
  CHECK(read_regular_file("/proc/self/status", 1 << 20, text) == "");
  CHECK(read_regular_file(folder.path() + "/none", 1, text) ==
        "cannot be read (No such file or directory)");
}

TEST_CASE("files: a session file has a longest length") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/long.toml";
  std::ofstream(path) << std::string(kMostConfigText, '#');
  CHECK(read_config_text(path).size() == kMostConfigText);
  // the deepest nesting that fits; the parser is recursive
  std::string deep;
  while (deep.size() + 6 < kMostConfigText) deep += "a.";
  CHECK_THAT(test::refusal([&] { parse_config(deep + "b = 1", path); }),
             Catch::Contains("the file has no 'session'"));
  CHECK_THAT(test::refusal([&] { parse_config(deep + deep + "b = 1", path); }),
             Catch::StartsWith(path + ": has more than 32 KiB"));
  std::ofstream(path, std::ios::app) << '#';
  CHECK_THAT(test::refusal([&] { load_config(path); }),
             Catch::StartsWith(path + ": has more than 32 KiB; name a session file"));
}

TEST_CASE("csv: a line has a longest length, and a zero byte does not end it") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/long.csv";
  std::ofstream(path) << "a,b\n1,2\n" << std::string(70'000, '7') << ",1\n";
  CsvReader reader(path);
  REQUIRE(reader.next());
  CHECK_THAT(test::refusal([&] { reader.next(); }),
             Catch::StartsWith(path + ":3: is longer than 65536 characters"));
  std::ofstream(path) << "a,b\n1" << '\0' << ",2\n";
  CsvReader other(path);
  REQUIRE(other.next());
  CHECK_THROWS_AS(other.number(0), CsvError);
}

}  // namespace haptic
