// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/log/file_queue.h"

#include <fcntl.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/log/trace.h"
#include "proto/os/file_descriptor.h"
#include "proto/os/realtime.h"
#include "tests/support/disk/standing_disk.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::disk;
using test::StandingDisk;

struct File {
  test::TemporaryFolder folder;
  std::string path = folder.path() + "/file";
  FileDescriptor fd{::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600)};

  std::string content() const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

/// A piece by its number, as long as that.
std::vector<char> piece(size_t n) {
  return std::vector<char>(n % 700 + 1, static_cast<char>('a' + n % 26));
}

std::string pieces(size_t count) {
  std::string all;
  for (size_t n = 0; n < count; ++n) {
    for (const char c : piece(n)) all += c;
  }
  return all;
}

ServoFrame queued_frame(uint64_t tick) {
  ServoFrame frame{};
  frame.tick = tick;
  frame.t_ns = static_cast<int64_t>(tick) * 1'000'000;
  return frame;
}

}  // namespace

TEST_CASE(
    "file queue: a disk that stands still keeps nobody waiting, and all gets there in order") {
  const File file;
  FileQueue queue(file.fd.get());
  {
    StandingDisk standing;
    for (size_t n = 0; n < 1000; ++n) queue.append(piece(n), 100);
    CHECK(queue.written().bytes == 0);
    standing.move();
    CHECK_FALSE(standing.was_waited_for());
  }
  queue.wait();
  CHECK(queue.written().error == 0);
  CHECK(queue.written().bytes == pieces(1000).size());
  CHECK(file.content() == pieces(1000));
}

TEST_CASE("file queue: what is on its way is bounded, then the disk is waited for") {
  const File file;
  std::atomic<bool> done{false};
  std::thread writer;
  constexpr size_t kPiece = 1 << 20, kPieces = FileQueue::kMostWaiting / kPiece + 8;
  {
    FileQueue queue(file.fd.get());
    StandingDisk standing;
    writer = std::thread([&] {
      for (size_t n = 0; n < kPieces; ++n) queue.append(std::vector<char>(kPiece), 0);
      done = true;
    });
    sleep_until(now_ns() + 100'000'000);
    CHECK_FALSE(done);
    standing.move();
    CHECK_FALSE(standing.was_waited_for());
    writer.join();
  }
  CHECK(done);
  // a queue that ends has written everything
  CHECK(std::filesystem::file_size(file.path) == kPieces * kPiece);
}

TEST_CASE("file queue: after an error nothing more is written, and nobody waits") {
  const File file;
  FileQueue queue(file.fd.get());
  disk.room = 5000;
  for (size_t n = 0; n < 300; ++n) queue.append(piece(n), 0);
  queue.wait();
  for (size_t n = 300; n < 600; ++n) queue.append(piece(n), 0);
  queue.wait();
  CHECK(disk.room == INT64_MAX);
  CHECK(queue.written().error == ENOSPC);
  // the last piece that is there whole
  size_t whole = 0, bytes = 0;
  while (bytes + piece(whole).size() <= 5000) bytes += piece(whole++).size();
  CHECK(queue.written().bytes == bytes);
  CHECK(file.content().substr(0, bytes) == pieces(whole));
}

TEST_CASE("file queue: a recording on a disk that stands still misses no record") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/run.mcap";
  constexpr uint64_t kFrames = 20'000;
  {
    TraceWriter trace(path, {});
    StandingDisk standing;
    for (uint64_t tick = 1; tick <= kFrames; ++tick) {
      REQUIRE(trace.write(servo_topic(kFirstHand), queued_frame(tick), {}));
    }
    REQUIRE(trace.close_chunk());
    // nothing is said to be in the file before it is
    CHECK(trace.written(servo_topic(kFirstHand).name) == 0);
    standing.move();
    CHECK_FALSE(standing.was_waited_for());
    REQUIRE(trace.flush());
    CHECK(trace.written(servo_topic(kFirstHand).name) == kFrames);
    REQUIRE(trace.close());
  }
  uint64_t next = 1;
  for (const ServoFrame& frame : TraceReader(path).read(servo_topic(kFirstHand))) {
    CHECK(frame.tick == next++);
  }
  CHECK(next == kFrames + 1);
}

TEST_CASE("file queue: a recording that ends amid what is on its way counts what is in the file") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/run.mcap";
  uint64_t written = 0;
  {
    TraceWriter trace(path, {});
    StandingDisk standing;
    for (uint64_t tick = 1; tick <= 5000; ++tick) {
      REQUIRE(trace.write(servo_topic(kFirstHand), queued_frame(tick), {}));
      if (tick % 100 == 0) REQUIRE(trace.close_chunk());
      if (tick % 1000 != 0) continue;
      const std::string name = "mark " + std::to_string(tick);
      trace.add_metadata(name, {{"at", "here"}});
      trace.add_channel("/" + name, "std_msgs/msg/Empty", "", "a topic that comes late");
    }
    // the end then has the room that was reserved for it
    disk.room = 20'000;
    standing.move();
    CHECK_FALSE(trace.flush());
    CHECK_FALSE(trace.close());
    CHECK(trace.error().find("No space left on device") != std::string::npos);
    CHECK(trace.error().find("the file is complete") != std::string::npos);
    written = trace.written(servo_topic(kFirstHand).name);
  }
  // read by its index, which has what is in the file and nothing else
  const TraceReader read(path);
  REQUIRE(read.mcap().finished());
  const std::vector<ServoFrame> frames = read.read(servo_topic(kFirstHand));
  CHECK(frames.size() == written);
  CHECK(written > 0);
  CHECK(written < 5000);
  CHECK(written % 100 == 0);
  for (size_t i = 0; i < frames.size(); ++i) CHECK(frames[i].tick == i + 1);
  // marks as far as the file goes, and no others
  size_t marks = 0;
  for (const auto& [name, content] : read.mcap().metadata()) marks += name.rfind("mark ", 0) == 0;
  CHECK(marks == (written - 1) / 1000);
  CHECK((read.mcap().find_channel("/mark 1000") != nullptr) == (marks > 0));
  CHECK(read.mcap().find_channel("/mark 5000") == nullptr);
}

}  // namespace haptic
