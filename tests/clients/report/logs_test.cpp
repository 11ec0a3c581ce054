// SPDX-License-Identifier: GPL-3.0-or-later
// Checks the summary of a recording, the differences of two, and one that was cut, against records
// made here.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "clients/log/recover.h"
#include "clients/log/trace_writer.h"
#include "clients/report/log_diff.h"
#include "clients/report/log_info.h"
#include "proto/log/trace.h"
#include "proto/math/units.h"
#include "tests/support/frames.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr int64_t kBegin = 1'700'000'000'000'000'000;  // on CLOCK_REALTIME [ns]

ServoFrame frame_of(uint64_t tick) {
  ServoFrame frame{};
  frame.tick = tick;
  frame.t_ns = static_cast<int64_t>(tick) * kMs;
  frame.realtime_ns = kBegin + frame.t_ns;
  frame.X_WP.p.x = 1e-3 * static_cast<double>(tick);
  frame.renderer = 0;
  if (tick % 4 == 0) {
    frame.flags = kServoContact;
    frame.F_device_B.f.z = 2.5;
  }
  return frame;
}

template <typename Change>
std::string log_of(const std::string& path, uint64_t ticks, const Change& change) {
  TraceWriter trace(path, recording_metadata("made", "text of a config"));
  const uint16_t foreign = trace.add_channel("/tf", "tf2_msgs/msg/TFMessage", "uint8 a\n", "other");
  for (uint64_t tick = 0; tick < ticks; ++tick) {
    ServoFrame frame = frame_of(tick);
    change(frame);
    const Stamp stamp{frame.t_ns, frame.realtime_ns, tick};
    trace.write(servo_topic(kFirstHand), frame, stamp);
    const std::byte bytes[5]{};
    if (tick % 10 == 0) trace.write_message(foreign, bytes, stamp);
  }
  trace.add_metadata("counts", {{"/servo0/frame lost", "7"}});
  REQUIRE(trace.close());
  return path;
}

}  // namespace

TEST_CASE("log info: counts, rates, contact, force and losses of a recording of known contents") {
  const test::TemporaryFolder folder;
  const std::string path = log_of(folder.path() + "/a.mcap", 1001, [](ServoFrame& frame) {
    if (frame.tick >= 500) frame.skipped = 3;
    if (frame.tick == 900) frame.fault = 5, frame.flags |= kServoFault;
  });
  const LogInfo info = read_log_info(path);
  CHECK(info.session == "made");
  CHECK(info.duration == Approx(1.0));
  CHECK(info.frames == 1001);
  CHECK(info.touching == 251);
  CHECK(info.max_force == 2.5);
  CHECK(info.late_ticks == 3);
  CHECK(info.fault_ticks == 1);
  CHECK(info.faults == std::set<std::string>{"pose jump"});
  CHECK(info.renderers == std::set<std::string>{"god-object3"});
  CHECK((info.has_config && info.was_finished && info.knows_losses));
  CHECK(info.lost == 7);
  REQUIRE(info.topics.size() == 6);
  CHECK(info.topics[0].topic == "/servo0/frame");
  CHECK(info.topics[0].rate == Approx(1000));
  CHECK((info.topics[0].ours && info.topics[0].lost == 7));
  CHECK(info.topics[5].topic == "/tf");
  CHECK(info.topics[5].count == 101);
  CHECK_FALSE(info.topics[5].ours);
  CHECK(TraceReader(path).topics().size() == 5);
}

TEST_CASE("log diff: the first difference, how many, and their root mean square") {
  const test::TemporaryFolder folder;
  const auto none = [](ServoFrame&) {};
  const std::string a = log_of(folder.path() + "/a.mcap", 400, none);
  const std::string same = log_of(folder.path() + "/same.mcap", 400, [](ServoFrame& frame) {
    frame.busy_ns = 17, frame.t_ns += 5, frame.realtime_ns += 9;
  });
  CHECK(diff_logs(a, a, "", true).is_equal());
  CHECK(diff_logs(a, same, "", false).is_equal());
  const LogDiff exact = diff_logs(a, same, "", true);
  CHECK(exact.different == 400);
  CHECK(exact.first_field == "t_ns");

  const std::string b = log_of(folder.path() + "/b.mcap", 390, [](ServoFrame& frame) {
    if (frame.tick >= 300) frame.X_WP.p.y += 2e-3, frame.F_device_B.f.x += 0.5;
  });
  const LogDiff diff = diff_logs(a, b, "", false);
  CHECK(diff.common == 390);
  CHECK(diff.only_a == 10);
  CHECK(diff.only_b == 0);
  CHECK(diff.different == 90);
  CHECK(diff.first_tick == 300);
  CHECK(diff.first_field == "X_WP.position.y");
  CHECK((diff.first_a == 0 && diff.first_b == 2e-3));
  CHECK(diff.rms_force == Approx(0.5 * std::sqrt(90.0 / 390)));
  CHECK(diff.rms_proxy == Approx(2e-3 * std::sqrt(90.0 / 390)));
}

TEST_CASE("log recover: a file cut anywhere gives a complete one with the frames from the start") {
  const test::TemporaryFolder folder;
  const std::string a = log_of(folder.path() + "/a.mcap", 3000, [](ServoFrame& frame) {
    // does not compress well: the cut chunk is long
    frame.X_WT.p.x = std::sin(static_cast<double>(frame.tick * frame.tick));
  });
  std::ifstream file(a, std::ios::binary);
  std::stringstream all;
  all << file.rdbuf();
  const std::string bytes = all.str();
  const std::vector<McapChunkIndex> chunks = McapReader(a).chunks();
  REQUIRE(chunks.size() > 5);
  const std::vector<ServoFrame> frames = TraceReader(a).read(servo_topic(kFirstHand));
  uint64_t rescued = 0;
  for (const size_t at : {size_t{chunks[3].offset + 3}, size_t{chunks[3].offset + 60},
                          size_t{chunks[4].offset - 2}, size_t{chunks[4].offset},
                          size_t{chunks[5].offset + chunks[5].length - 1}, bytes.size() - 4}) {
    CAPTURE(at);
    const std::string cut = folder.path() + "/cut.mcap", whole = folder.path() + "/whole.mcap";
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, at);
    const Recovered got = recover_log(cut, whole);
    CHECK_FALSE(got.had_end);
    rescued += got.rescued;
    const McapReader reader(whole);
    CHECK(reader.finished());
    CHECK(reader.metadata().at("recording").at("session") == "made");
    CHECK(reader.metadata().contains("recovered"));
    const std::vector<ServoFrame> kept = TraceReader(whole).read(servo_topic(kFirstHand));
    CHECK(kept.size() >= TraceReader(cut).read(servo_topic(kFirstHand)).size());
    CHECK(kept.size() == got.messages.at("/servo0/frame"));
    REQUIRE(kept.size() <= frames.size());
    CHECK(std::equal(kept.begin(), kept.end(), frames.begin(), [](const auto& x, const auto& y) {
      return test::bytes_in_use(x) == test::bytes_in_use(y);
    }));
  }
  CHECK(rescued > 0);
  CHECK(recover_log(a, folder.path() + "/copy.mcap").had_end);
  CHECK(diff_logs(a, folder.path() + "/copy.mcap", "", true).is_equal());
}

TEST_CASE("log recover: a damaged chunk is left out and named, those after it are kept") {
  const test::TemporaryFolder folder;
  const std::string a = log_of(folder.path() + "/a.mcap", 1000, [](ServoFrame&) {});
  const McapChunkIndex chunk = McapReader(a).chunks()[1];
  std::fstream file(a, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(chunk.offset + chunk.length / 2));
  file << "damage";
  file.close();
  const Recovered got = recover_log(a, folder.path() + "/b.mcap");
  CHECK(got.had_end);
  REQUIRE(got.damaged.size() == 1);
  CHECK(got.lost_bytes == chunk.length);
  CHECK(got.chunks + 1 == McapReader(a).chunks().size());
  CHECK(TraceReader(folder.path() + "/b.mcap").read(servo_topic(kFirstHand)).back().tick == 999);
}

TEST_CASE("log: a reader that refreshes finds what is appended, and the end") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/grows.mcap";
  TraceWriter trace(path, {});
  McapReader reader(path);
  CHECK(reader.chunks().empty());
  CHECK_FALSE(reader.refresh());
  for (uint64_t round = 1; round <= 3; ++round) {
    trace.write(servo_topic(kFirstHand), frame_of(round), {1, 2, 3});
    CHECK_FALSE(reader.refresh());
    trace.flush();
    CHECK(reader.refresh());
    CHECK(reader.chunks().size() == round);
    CHECK_FALSE(reader.finished());
  }
  trace.close();
  CHECK(reader.refresh());
  CHECK(reader.finished());
  CHECK(reader.chunks().size() == 3);
}

}  // namespace haptic
