// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a small file that looks like a recording.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "proto/log/mcap.h"
#include "tests/proto/log/mcap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::chunk;
using test::chunk_index;
using test::kMcapMagic;
using test::McapBytes;

struct Written : test::TemporaryFolder {
  std::string file = path() + "/hostile.mcap";
  explicit Written(const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }
};

/// Number of messages of channel 1; -1 and the reason if the file is refused.
int64_t count_messages(const std::string& file, std::string& why) {
  int64_t n = 0;
  try {
    const McapReader reader(file);
    for (const McapChunkIndex& chunk : reader.chunks()) {
      reader.for_each_in(chunk, [&](const McapMessage& message) { n += message.channel == 1; });
    }
    return n;
  } catch (const McapError& error) {
    why = error.what();
    return -1;
  }
}

/// A file without an end that holds this chunk.
std::string file_with(const McapBytes& content) {
  return McapBytes().raw(kMcapMagic).record(0x06, content).bytes();
}

/// Peak memory of a forked process beyond this one's [bytes].
int64_t peak_of(const std::function<void()>& body) {
  const auto run = [](const std::function<void()>& what) {
    const pid_t pid = fork();
    if (pid == 0) {
      what();
      _exit(0);
    }
    rusage usage{};
    int status = 0;
    REQUIRE(wait4(pid, &status, 0, &usage) == pid);
    REQUIRE(WIFEXITED(status));
    return int64_t{usage.ru_maxrss} * 1024;
  };
  return run(body) - run([] {});
}

}  // namespace

TEST_CASE("mcap: a small file that unpacks to a gigabyte is refused before it takes the memory") {
  constexpr uint64_t kBlocks = 6500, kEach = 128 << 10;
  const std::string bomb = test::repeating_frame(kBlocks, kEach, kBlocks * kEach);
  const Written honest(file_with(chunk(kBlocks * kEach, "zstd", bomb)));
  const Written liar(file_with(chunk(1000, "zstd", bomb)));
  CHECK(std::filesystem::file_size(honest.file) < 27'000);
  std::string why;
  CHECK(count_messages(honest.file, why) == -1);
  CHECK_THAT(why, Catch::EndsWith(": chunk at byte 8 claims 812 MiB, more than the 16 that a chunk "
                                  "may hold; write it with smaller ones"));
  CHECK(count_messages(liar.file, why) == -1);
  CHECK_THAT(why, Catch::EndsWith("cannot be unpacked; the file is damaged"));
  if (test::kSlowdown > 1) return;  // a sanitizer's memory is not the program's
  for (const Written* written : {&honest, &liar}) {
    CHECK(peak_of([&] { count_messages(written->file, why); }) < (8 << 20));
  }
}

TEST_CASE("mcap: the largest chunk that is read is 16 MiB") {
  constexpr uint64_t kEach = 128 << 10;
  // messages are records, and a record of zeros is empty: opcode 0, nine bytes each
  const auto largest = [&](uint32_t blocks) {
    return file_with(
        chunk(blocks * kEach, "zstd", test::repeating_frame(blocks, kEach, blocks * kEach)));
  };
  std::string why;
  count_messages(Written(largest(128)).file, why);
  CHECK_THAT(why, Catch::EndsWith("is cut; the file is damaged"));  // 16 MiB is not a multiple of 9
  count_messages(Written(largest(129)).file, why);
  CHECK_THAT(why, Catch::Contains("claims 16 MiB, more than the 16"));
}

TEST_CASE("mcap: what an index names twice is read once") {
  const std::string packed = McapBytes().record(0x05, test::message("x")).bytes();
  const std::string start = file_with(chunk(packed.size(), "", packed));
  const uint64_t length = start.size() - kMcapMagic.size();
  McapBytes summary;
  for (int i = 0; i < 1000; ++i) summary.record(0x08, chunk_index(kMcapMagic.size(), length));
  std::string why;
  CHECK(count_messages(Written(start + test::mcap_end(start.size(), summary)).file, why) == 1);

  // and a valid index is used
  McapBytes sound;
  sound.record(0x08, chunk_index(kMcapMagic.size(), length));
  const Written whole(start + test::mcap_end(start.size(), sound));
  CHECK(McapReader(whole.file).finished());
  CHECK(count_messages(whole.file, why) == 1);
}

TEST_CASE("mcap: a chunk that is not as long as its index says is not read") {
  const std::string packed = McapBytes().record(0x05, test::message("x")).bytes();
  const std::string start = file_with(chunk(packed.size(), "", packed));
  McapBytes summary;
  summary.record(0x08, chunk_index(kMcapMagic.size(), 9));
  std::string why;
  CHECK(count_messages(Written(start + test::mcap_end(start.size(), summary)).file, why) == -1);
  CHECK_THAT(why, Catch::EndsWith("chunk at byte 8 is not there"));
}

TEST_CASE("mcap: a record longer than the longest chunk is not read into memory") {
  // a sparse file: as long as it claims, with no byte on the disk
  const Written written(
      McapBytes().raw(kMcapMagic).number(uint8_t{0x0C}).number(uint64_t{1} << 40).bytes());
  std::filesystem::resize_file(written.file, (uint64_t{1} << 40) + 100);
  std::string why;
  CHECK(count_messages(written.file, why) == -1);
  CHECK_THAT(why, Catch::Contains("has 1048576 MiB, more than the 17 that are read"));
}

TEST_CASE("mcap: zeros behind the last record are the end, however many there are") {
  const std::string packed = McapBytes().record(0x05, test::message("x")).bytes();
  const Written written(file_with(chunk(packed.size(), "", packed)));
  std::filesystem::resize_file(written.file, uint64_t{1} << 40);
  std::string why;
  CHECK(count_messages(written.file, why) == 1);
}

TEST_CASE("mcap: schemas and channels have a bound") {
  McapBytes file;
  file.raw(kMcapMagic);
  const int op = GENERATE(0x03, 0x04);
  for (uint16_t id = 0; id < 1025; ++id) {
    McapBytes named;
    named.number(id);
    if (op == 0x04) named.number(id);
    file.record(static_cast<uint8_t>(op), named.text("").text("").text(""));
  }
  std::string why;
  CHECK(count_messages(Written(file.bytes()).file, why) == -1);
  CHECK_THAT(why, Catch::Contains("has more than 1024"));
}

}  // namespace haptic
