// SPDX-License-Identifier: GPL-3.0-or-later
// The account of samples on recordings with planted gaps, and the proportions of the faults.
#include "clients/lab/torture/account.h"

#include <catch2/catch.hpp>

#include "clients/lab/torture/faults.h"
#include "clients/log/trace_writer.h"
#include "proto/log/trace.h"
#include "proto/math/units.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr int64_t kStart = 9'000 * kMs;

/// A recording of one frame per millisecond from `from` to `to` [ms], without those in `missing`.
RecordingPart record(const std::string& path, int64_t from, int64_t to,
                     const std::vector<int64_t>& missing = {}, double told_lost = 0) {
  TraceWriter trace(path, {});
  for (int64_t ms = from; ms < to; ++ms) {
    if (std::find(missing.begin(), missing.end(), ms) != missing.end()) continue;
    ServoFrame frame{};
    frame.t_ns = kStart + ms * kMs;
    trace.write(servo_topic(kFirstHand), frame, {frame.t_ns, frame.t_ns, 0});
  }
  if (told_lost > 0) {
    // what the client 5 has lost by flooding its ring is its own affair
    for (const uint32_t source : {3u, 0x85u}) {
      const Event event{
          kStart, static_cast<uint32_t>(EventCode::kRecordsLost), source, {told_lost}};
      trace.write(kEventTopic, event, {kStart, kStart, 0});
    }
  }
  REQUIRE(trace.close());
  return {path, static_cast<size_t>(to)};
}

/// One frame per millisecond, seen at once.
std::vector<SeenFrame> published(int64_t n) {
  std::vector<SeenFrame> frames;
  for (int64_t ms = 0; ms < n; ++ms) frames.push_back({kStart + ms * kMs, kStart + ms * kMs});
  return frames;
}

}  // namespace

TEST_CASE("account: what is in the files is recorded, what came before and after is nobody's") {
  const test::TemporaryFolder folder;
  const RecordingPart part = record(folder.path() + "/a.mcap", 100, 900);
  const SampleAccount account = account_for_samples({part}, published(1000));
  CHECK(account.published == 900);
  CHECK(account.recorded == 800);
  CHECK(account.explained == 100);  // after the recorder was told to end
  CHECK(account.unexplained == 0);
  CHECK(account.told == 0);
}

TEST_CASE("account: a frame that is missing in the middle is unexplained") {
  const test::TemporaryFolder folder;
  RecordingPart part = record(folder.path() + "/a.mcap", 0, 1000, {400, 401, 999}, 7);
  SampleAccount account = account_for_samples({part}, published(1000));
  CHECK(account.unexplained == 3);
  CHECK(account.told == 7);
  // a recorder that is still running explains no loss either
  part.n_seen = RecordingPart::kRuns;
  CHECK(account_for_samples({part}, published(1000)).unexplained == 3);
  // a kill costs the end of the file, not frames before one that was written
  part.killed_ns = kStart + 500 * kMs;
  account = account_for_samples({part}, published(1000));
  CHECK(account.unexplained == 2);
  CHECK(account.explained == 1);
}

TEST_CASE("account: a frame that was due before the end and came after it is nobody's") {
  const test::TemporaryFolder folder;
  RecordingPart part = record(folder.path() + "/a.mcap", 0, 900);
  // the servo stalled in the tick of 900 ms, and ended with a frame of the same time
  std::vector<SeenFrame> frames = published(901);
  frames.back().seen_ns += 12'000 * kMs;
  frames.push_back(frames.back());
  SampleAccount account = account_for_samples({part}, frames);
  CHECK(account.explained == 2);
  CHECK(account.unexplained == 0);
  // seen before the end, it had to be in the file
  part.n_seen = 901;
  account = account_for_samples({part}, frames);
  CHECK(account.explained == 1);
  CHECK(account.unexplained == 1);
  // and so had a frame with the same time as one in the file
  part.n_seen = 902;
  frames[900] = frames[901] = frames[899];
  CHECK(account_for_samples({part}, frames).unexplained == 2);
  // a killed recorder did not receive the late frame in time to write it
  part.killed_ns = frames[900].seen_ns = frames[901].seen_ns = kStart + 20'000 * kMs;
  CHECK(account_for_samples({part}, frames).unexplained == 0);
}

TEST_CASE("account: a killed recorder explains its open chunk, and no more") {
  const test::TemporaryFolder folder;
  RecordingPart killed = record(folder.path() + "/a.mcap", 0, 700);
  killed.n_seen = 950;
  killed.killed_ns = kStart + 950 * kMs;
  // 250 ms were open, and nothing was recorded until the next recorder began
  const RecordingPart next = record(folder.path() + "/b.mcap", 1000, 2000);
  SampleAccount account = account_for_samples({killed, next}, published(2000));
  CHECK(account.recorded == 1700);
  CHECK(account.explained == 300);
  CHECK(account.unexplained == 0);
  killed.n_seen = 1000;
  killed.killed_ns = kStart + 1000 * kMs;
  account = account_for_samples({killed, next}, published(2000));
  CHECK(account.unexplained == 10);
  // a recorder that was not killed may not lose any
  killed.killed_ns = 0;
  CHECK(account_for_samples({killed, next}, published(2000)).unexplained == 300);
}

TEST_CASE("account: a machine that stands still keeps a chunk open, for as long and no longer") {
  const test::TemporaryFolder folder;
  RecordingPart killed = record(folder.path() + "/a.mcap", 0, 500);
  killed.n_seen = 1000;
  killed.killed_ns = kStart + 1000 * kMs;
  const auto unexplained = [&](std::vector<Stall> stalls) {
    killed.stalls = std::move(stalls);
    return account_for_samples({killed}, published(1000)).unexplained;
  };
  const auto stall = [](int64_t from, int64_t to) {
    return Stall{kStart + from * kMs, kStart + to * kMs};
  };
  CHECK(unexplained({}) == 210);
  CHECK(unexplained({stall(800, 900)}) == 110);
  // the second lies in the time added by the first
  CHECK(unexplained({stall(640, 700), stall(800, 900)}) == 50);
  CHECK(unexplained({stall(100, 400)}) == 210);
  CHECK(unexplained({stall(790, 1000)}) == 0);
}

TEST_CASE("account: a file that cannot be read is named") {
  const SampleAccount account = account_for_samples({{"/no/such/file.mcap"}}, published(10));
  REQUIRE(account.unreadable.size() == 1);
  CHECK(account.unreadable.front().find("/no/such/file.mcap") != std::string::npos);
}

TEST_CASE("faults: a hundred hold every kind, and the servo and hapticd six of them at most") {
  int sum = 0, servo_and_hapticd = 0;
  for (const FaultInfo& fault : all_faults()) {
    CHECK(&info_of(fault.kind) == &fault);
    CHECK(fault.share > 0);
    // on top come those of torque, where the device has six motors, and those of who moves the
    // block
    sum += fault.is_of_six || fault.is_of_given ? 0 : fault.share;
    const bool counts = fault.name.find("servo") == 0 || fault.name.find("hapticd") == 0;
    if (counts) servo_and_hapticd += fault.share;
  }
  CHECK(sum == 100);
  CHECK(servo_and_hapticd <= 6);
}

}  // namespace haptic
