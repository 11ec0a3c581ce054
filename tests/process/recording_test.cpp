// SPDX-License-Identifier: GPL-3.0-or-later
// What `hapt record` writes, where it refuses to, and invalid recordings: on the real binaries.
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "clients/log/log_eyes.h"
#include "proto/config/config.h"
#include "proto/ipc/eye_file.h"
#include "proto/log/trace.h"
#include "tests/process/hapt_command.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

/// A running session with its own session file.
struct RecordedSession {
  TemporaryRuntimeFolder folder;
  std::string text =
      read_config_text(test::from_source("configs/plane.toml")) + "# of this test alone\n";
  std::string file = write();
  HapticdProcess hapticd{{file, "--session", "recorded"}, folder.path()};
  Watcher watcher{"recorded"};

  RecordedSession() { REQUIRE(watcher.wait_for_all()); }
  std::string write() const {
    std::string path = folder.path() + "/own.toml";
    std::ofstream(path) << text;
    return path;
  }
};

std::string config_in(const std::string& recording) {
  return TraceReader(recording).mcap().metadata().at("recording").at("config");
}

}  // namespace

TEST_CASE("hapt record: the recording holds the session file that hapticd has read") {
  const RecordedSession session;
  // the file it was started with, whatever has replaced it since
  std::ofstream(session.file) << "something else";
  const Ran ran = hapt("record -o run.mcap --for 0.3", session.folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(config_in(session.folder.path() + "/run.mcap") == session.text);
  CHECK(hapt("config", session.folder.path()).output == session.text);
}

TEST_CASE("hapt record: a user who may watch is not told the session file") {
  if (geteuid() != 0) {
    WARN("SKIPPED: needs root, to become somebody else");
    return;
  }
  const RecordedSession session;
  namespace fs = std::filesystem;
  fs::permissions(session.folder.path(), fs::perms(0755));
  const std::string open = session.folder.path() + "/open";
  fs::create_directory(open);
  fs::permissions(open, fs::perms::all);
  const Ran ran =
      shell("setpriv --reuid 65534 --clear-groups hapt record -o open/run.mcap --for 0.3",
            session.folder.path());
  INFO(ran.output);
  CHECK(ran.code == 0);
  CHECK(has(ran.output, "the recording will not hold the session file: only user 0 and root"));
  CHECK(config_in(open + "/run.mcap").empty());
}

TEST_CASE("hapt record: what is no file is refused, and a full one ends with the count of losses") {
  const RecordedSession session;
  const std::string folder = session.folder.path();
  REQUIRE(mkfifo((folder + "/pipe").c_str(), 0600) == 0);
  for (const std::string output : {"/dev/null", "/dev/full", "pipe"}) {
    const Ran ran = shell("timeout 20 hapt record --for 5 -o " + output, folder);
    CAPTURE(output, ran.output);
    CHECK(ran.code == 1);
    CHECK(lines(ran.output) == 1);
    CHECK(has(ran.output, output == "pipe" ? "is a pipe" : "is a device"));
  }
  const Ran full = shell("ulimit -f 100; timeout 60 hapt record -o full.mcap", folder);
  INFO(full.output);
  CHECK(full.code == 1);
  CHECK(has(full.output, "File too large after "));
  CHECK(has(full.output, "; lost: "));
  CHECK(TraceReader(folder + "/full.mcap").mcap().finished());
}

TEST_CASE("hapt info, diff, recover: of a real recording, and of one that was cut") {
  const RecordedSession session;
  const std::string folder = session.folder.path();
  REQUIRE(hapt("record -o run.mcap --for 0.8", folder).code == 0);
  const Ran info = hapt("info run.mcap", folder);
  INFO(info.output);
  CHECK(info.code == 0);
  CHECK(has(info.output, "/servo0/frame"));
  CHECK(hapt("diff run.mcap run.mcap --exact", folder).code == 0);

  // how the block is drawn is in it
  const McapReader whole(folder + "/run.mcap");
  const LogEyes eyes = read_log_eyes(whole);
  CHECK_FALSE(eyes.tools[kFirstHand].empty());
  REQUIRE(eyes.objects.contains(0));
  CHECK(view_eye(eyes.objects.at(0)).name == "block");
  CHECK(whole.find_channel("/scene/markers/object_0") != nullptr);

  std::filesystem::copy_file(folder + "/run.mcap", folder + "/cut.mcap");
  std::filesystem::resize_file(folder + "/cut.mcap", whole.chunks().back().offset + 100);
  CHECK(has(hapt("info cut.mcap", folder).output, "missing"));
  const Ran recovered = hapt("recover cut.mcap -o mended.mcap", folder);
  INFO(recovered.output);
  CHECK(recovered.code == 0);
  CHECK(has(recovered.output, "its recorder was killed"));
  CHECK(McapReader(folder + "/mended.mcap").finished());
  CHECK(read_log_eyes(McapReader(folder + "/mended.mcap")).objects == eyes.objects);
  const Ran diff = hapt("diff run.mcap mended.mcap", folder);
  INFO(diff.output);
  CHECK(diff.code == 1);
  CHECK(has(diff.output, " 0 differ; "));
  CHECK(has(diff.output, " 0 only in B"));
  CHECK(hapt("diff run.mcap none.mcap", folder).code == 2);
}

}  // namespace haptic
