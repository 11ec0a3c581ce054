// SPDX-License-Identifier: GPL-3.0-or-later
// The account of samples on recordings with planted gaps, and the quota of the faults.
#include "clients/torture_account.h"

#include <catch2/catch.hpp>

#include "clients/faults.h"
#include "proto/trace.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kStart = 9'000 * kMs;

/// A recording of one frame a millisecond from `from` up to `to` [ms], without those in `missing`.
RecordingPart record(const std::string& path, int64_t from, int64_t to,
                     const std::vector<int64_t>& missing = {}, double told_lost = 0) {
  TraceWriter trace(path, {});
  for (int64_t ms = from; ms < to; ++ms) {
    if (std::find(missing.begin(), missing.end(), ms) != missing.end()) continue;
    ServoFrame frame{};
    frame.t_ns = kStart + ms * kMs;
    trace.write(kServo0Topic, frame, {frame.t_ns, frame.t_ns, 0});
  }
  if (told_lost > 0) {
    const Event event{kStart, static_cast<uint32_t>(EventCode::kRecordsLost), 3, {told_lost}};
    trace.write(kEventTopic, event, {kStart, kStart, 0});
  }
  REQUIRE(trace.close());
  return {path, kStart + to * kMs, false};
}

std::vector<int64_t> published(int64_t n) {
  std::vector<int64_t> times;
  for (int64_t ms = 0; ms < n; ++ms) times.push_back(kStart + ms * kMs);
  return times;
}

}  // namespace

TEST_CASE("account: what is in the files is recorded, what came before and after is nobody's") {
  const test::TemporaryFolder folder;
  const RecordingPart part = record(folder.path() + "/a.mcap", 100, 900);
  const SampleAccount account = account_for_samples({part}, published(1000));
  CHECK(account.published == 900);
  CHECK(account.recorded == 800);
  CHECK(account.explained == 100);  // after it had been told to end
  CHECK(account.unexplained == 0);
  CHECK(account.told == 0);
}

TEST_CASE("account: a frame that is missing in the middle is unexplained") {
  const test::TemporaryFolder folder;
  const RecordingPart part = record(folder.path() + "/a.mcap", 0, 1000, {400, 401, 999}, 7);
  const SampleAccount account = account_for_samples({part}, published(1000));
  CHECK(account.unexplained == 3);
  CHECK(account.told == 7);
}

TEST_CASE("account: a killed recorder explains its open chunk, and no more") {
  const test::TemporaryFolder folder;
  RecordingPart killed = record(folder.path() + "/a.mcap", 0, 700);
  killed.killed = true;
  killed.ended_ns = kStart + 950 * kMs;
  // 250 ms were open, nobody recorded until the next one began
  const RecordingPart next = record(folder.path() + "/b.mcap", 1000, 2000);
  SampleAccount account = account_for_samples({killed, next}, published(2000));
  CHECK(account.recorded == 1700);
  CHECK(account.explained == 300);
  CHECK(account.unexplained == 0);
  killed.ended_ns = kStart + 1000 * kMs;
  account = account_for_samples({killed, next}, published(2000));
  CHECK(account.unexplained == 10);
  // one that was not killed had no right to lose any
  killed.killed = false;
  CHECK(account_for_samples({killed, next}, published(2000)).unexplained == 300);
}

TEST_CASE("account: a file that cannot be read is named") {
  const SampleAccount account = account_for_samples({{"/no/such/file.mcap"}}, published(10));
  REQUIRE(account.unreadable.size() == 1);
  CHECK(account.unreadable.front().find("/no/such/file.mcap") != std::string::npos);
}

TEST_CASE("faults: a hundred hold every kind, and the servo and hapticd five of them at most") {
  int sum = 0, servo_and_hapticd = 0;
  for (size_t i = 0; i < kFaults.size(); ++i) {
    CHECK(static_cast<size_t>(kFaults[i].kind) == i);
    CHECK(kFaults[i].share > 0);
    sum += kFaults[i].share;
    const bool counts = kFaults[i].name.find("servo") == 0 || kFaults[i].name.find("hapticd") == 0;
    if (counts) servo_and_hapticd += kFaults[i].share;
  }
  CHECK(sum == 100);
  CHECK(servo_and_hapticd <= 5);
}

}  // namespace haptic
