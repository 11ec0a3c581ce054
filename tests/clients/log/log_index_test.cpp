// SPDX-License-Identifier: GPL-3.0-or-later
// Random access to a recording, against the records that were written, in order.
#include "clients/log/log_index.h"
#include "clients/log/mcap_writer.h"
#include "clients/log/trace_writer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "clients/log/log_columns.h"
#include "clients/log/log_survey.h"
#include "proto/math/units.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr int64_t kBegin = 50 * kMs;

ServoFrame frame_of(uint64_t tick) {
  ServoFrame frame{};
  frame.tick = tick;
  frame.t_ns = kBegin + static_cast<int64_t>(tick) * kMs;
  frame.realtime_ns = frame.t_ns;
  frame.contact_seq = frame.contact_tick = tick < 2 ? 0 : tick - 1;
  if (tick < 2) frame.flags |= kServoNoContactSet;
  frame.scene_seq = tick / 8;
  frame.depth = 1e-3 * std::sin(static_cast<double>(tick) / 50);
  frame.X_WT.p.x = std::sin(static_cast<double>(tick * tick));
  if (tick % 500 > 400) frame.flags |= kServoContact, frame.F_device_B.f.z = 1;
  if (tick >= 900) frame.skipped = 1;
  return frame;
}

/// Drained every ten ticks as the recorder does: sets first, then frames. Tick 899 is skipped.
void write_ticks(TraceWriter& trace, uint64_t from, uint64_t to) {
  for (uint64_t begin = from; begin < to; begin += 10) {
    for (uint64_t tick = begin; tick < begin + 10; ++tick) {
      const int64_t t_ns = frame_of(tick).t_ns;
      if (tick % 8 == 0) {
        SceneFrame scene{};
        scene.seq = tick / 8, scene.t_ns = t_ns;
        trace.write(kSimTopic, scene, {t_ns, t_ns, scene.seq});
      }
      ContactSet set{};
      set.seq = set.answers_tick = tick, set.answers_t_ns = t_ns;
      trace.write(contact_topic(kFirstHand), set, {t_ns, t_ns, tick});
    }
    for (uint64_t tick = begin; tick < begin + 10; ++tick) {
      if (tick == 899) continue;
      const ServoFrame frame = frame_of(tick);
      trace.write(servo_topic(kFirstHand), frame, {frame.t_ns, frame.t_ns, tick});
    }
  }
}

void check_ticks(LogIndex& log, uint64_t end) {
  CHECK(log.first_tick() == 0);
  REQUIRE(log.last_tick() == end - 1);
  CHECK(log.rate() == 1000);
  for (uint64_t n = 0; n < 300; ++n) {
    const uint64_t tick = n * 7919 % end;
    CAPTURE(tick);
    const std::optional<ServoFrame> frame = log.frame_at(tick);
    REQUIRE(frame);
    REQUIRE(frame->tick == (tick == 899 ? 898 : tick));
    REQUIRE(frame->X_WT.p.x == frame_of(frame->tick).X_WT.p.x);
    const auto set = log.contacts_at(*frame);
    REQUIRE((set != nullptr) == (tick >= 2));
    if (set) REQUIRE(set->seq == frame->contact_seq);
    const auto scene = log.scene_at(*frame);
    REQUIRE(scene);
    REQUIRE(scene->seq == frame->scene_seq);
  }
}

}  // namespace

TEST_CASE("log columns: a recording has one for each hand that it holds") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/hands.mcap";
  const auto columns_of = [&](const std::vector<uint32_t>& hands) {
    std::vector<TopicInfo> topics;
    for (const uint32_t hand : hands) topics.push_back(*find_topic(servo_topic(hand).name));
    CHECK(TraceWriter(path, {}, topics).close());
    std::vector<std::string> found;
    for (const LogColumn& column : log_columns(TraceReader(path))) {
      found.push_back(column.name + " " + column.servo + " " + column.contact);
    }
    return found;
  };
  using Names = std::vector<std::string>;
  CHECK(columns_of({0}) == Names{"session /servo0/frame /contact0/set"});
  CHECK(columns_of({0, 3}) ==
        Names{"session /servo0/frame /contact0/set", "hand 3 /servo3/frame /contact3/set"});
  CHECK(find_topic("/servo4/frame") == nullptr);
}

TEST_CASE("log index: the records of any tick of a file with an end, and of one that was cut") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/a.mcap";
  TraceWriter trace(path, {});
  write_ticks(trace, 0, 3000);
  trace.close();
  LogIndex log(path);
  CHECK_FALSE(log.is_growing());
  CHECK(log.columns().size() == 1);
  check_ticks(log, 3000);
  CHECK(log.frame_at(5000)->tick == 2999);
  std::vector<uint64_t> ticks;
  log.for_each_frame(890, 905, 0, [&](const ServoFrame& frame) { ticks.push_back(frame.tick); });
  REQUIRE(ticks.size() == 15);
  CHECK((ticks.front() == 890 && ticks[8] == 898 && ticks[9] == 900 && ticks.back() == 905));

  const McapChunkIndex last = McapReader(path).chunks().back();
  std::stringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  const std::string cut = folder.path() + "/cut.mcap";
  std::ofstream(cut, std::ios::binary) << bytes.str().substr(0, last.offset + 20);
  LogIndex half(cut);
  CHECK(half.is_growing());
  CHECK(half.last_tick() > 2800);
  check_ticks(half, half.last_tick() + 1);
}

TEST_CASE("log index: follows a file that grows") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/grows.mcap";
  TraceWriter trace(path, {});
  write_ticks(trace, 0, 1000);
  trace.flush();
  LogIndex log(path);
  check_ticks(log, 1000);
  write_ticks(trace, 1000, 2000);
  trace.flush();
  CHECK(log.refresh());
  check_ticks(log, 2000);
  trace.close();
  CHECK(log.refresh());
  CHECK_FALSE(log.is_growing());
  CHECK_FALSE(log.refresh());
}

TEST_CASE("log index: ticks go on when a servo was started again") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/again.mcap";
  TraceWriter trace(path, {});
  const auto write = [&](uint64_t tick, int64_t t_ns) {
    ServoFrame frame{};
    frame.tick = tick, frame.t_ns = t_ns;
    trace.write(servo_topic(kFirstHand), frame, {t_ns, t_ns, tick});
  };
  for (uint64_t k = 0; k < 500; ++k) write(k + 7, static_cast<int64_t>(k) * kMs);
  // 600 ms later by its own grid
  for (uint64_t k = 0; k < 500; ++k) write(k, static_cast<int64_t>(k + 1100) * kMs + 333'333);
  trace.close();
  LogIndex log(path);
  CHECK(log.first_tick() == 7);
  CHECK(log.last_tick() == 7 + 1599);
  CHECK(log.frame_at(7 + 800)->tick == 506);
  CHECK(log.frame_at(7 + 1100)->tick == 0);
  CHECK(log.frame_at(7 + 1103)->tick == 3);
}

TEST_CASE("log survey: marks, and smallest and largest values as a scan of all frames has them") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/a.mcap";
  TraceWriter trace(path, {});
  write_ticks(trace, 0, 3000);
  trace.close();
  const LogIndex log(path);
  LogSurvey survey(log);
  size_t pieces = 0;
  while (survey.advance(3)) ++pieces;
  CHECK(pieces > 5);
  CHECK(survey.share() == 1);
  std::vector<uint64_t> contacts, late;
  for (const LogMark& mark : survey.marks()) {
    (mark.kind == MarkKind::kContact ? contacts : late).push_back(mark.tick);
  }
  CHECK(contacts == std::vector<uint64_t>{401, 901, 1401, 1901, 2401, 2901});
  CHECK(late == std::vector<uint64_t>{900});
  const std::vector<LogStep> steps = survey.overview(0, 2999, 10);
  REQUIRE(steps.size() == 10);
  for (const LogStep& step : steps) {
    double low = 1, high = -1;
    for (uint64_t tick = step.first_tick; tick <= step.last_tick; ++tick) {
      if (tick == 899) continue;
      low = std::min(low, frame_of(tick).depth), high = std::max(high, frame_of(tick).depth);
    }
    CHECK(step.low[kDepth] == low);
    CHECK(step.high[kDepth] == high);
    CHECK(step.last_tick == step.first_tick + 299);
  }
  CHECK(steps[2].frames == 299);
}

TEST_CASE("log index: no recording of a session") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/none.mcap";
  McapWriter(path).close();
  CHECK_THROWS_WITH(LogIndex(path), Catch::Contains("has no servo frames"));
}

/// Writes an hour (HAPTIC_LOG_SECONDS) of servo frames and contact sets, as many as a session has,
/// into HAPTIC_LOG_FOLDER and measures how long it takes to open it, to go to a tick, to survey it.
TEST_CASE("log index: a long recording, measured", "[.][log-hour]") {
  const char* folder = std::getenv("HAPTIC_LOG_FOLDER");
  const char* seconds = std::getenv("HAPTIC_LOG_SECONDS");
  REQUIRE(folder != nullptr);
  const std::string path = std::string(folder) + "/hour.mcap";
  const auto ticks = static_cast<uint64_t>(1000 * (seconds != nullptr ? std::atof(seconds) : 3600));
  if (!std::filesystem::exists(path)) {
    TraceWriter trace(path, {});
    write_ticks(trace, 0, ticks);
    trace.close();
  }
  using Clock = std::chrono::steady_clock;
  const auto ms = [](Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  };
  auto begin = Clock::now();
  LogIndex log(path);
  const double opened = ms(begin);
  std::vector<double> jumps;
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    const uint64_t tick = random() % ticks;
    begin = Clock::now();
    const auto frame = log.frame_at(tick);
    REQUIRE(frame);
    const auto set = log.contacts_at(*frame);
    const auto scene = log.scene_at(*frame);
    jumps.push_back(ms(begin));
    CHECK((set != nullptr && scene && set->seq == frame->contact_seq));
  }
  std::ranges::sort(jumps);
  begin = Clock::now();
  LogSurvey survey(log);
  while (survey.advance(1000)) {
  }
  std::printf(
      "%.0f s, %zu chunks, %.2f GiB: open %.0f ms; go to a tick: median %.1f ms, most %.1f ms;"
      " survey %.1f s\n",
      1e-3 * static_cast<double>(ticks), log.trace().mcap().chunks().size(),
      static_cast<double>(std::filesystem::file_size(path)) / (1 << 30), opened, jumps[50],
      jumps.back(), 1e-3 * ms(begin));
}

}  // namespace haptic
