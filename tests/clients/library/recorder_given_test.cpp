// SPDX-License-Identifier: GPL-3.0-or-later
// What clients give ends up in the recording, whatever they write and however often they come.
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "clients/library/recorder.h"
#include "clients/log/trace_writer.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "tests/proto/ipc/served.h"
#include "tests/support/frames.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr uint32_t kClient = 3;
constexpr uint64_t kSlots = decltype(ClientChannels::frames)::kCapacity;

/// A session with a recorder, and a client that gives to it.
struct GivenSession {
  test::TemporaryRuntimeFolder folder;
  HandoutServer server{"recorded"};
  std::string path = folder.path() + "/run.mcap";
  Attachments attachments{connect_session("recorded")};
  Recorder recorder{attachments, Start::kOldest};
  std::unique_ptr<TraceWriter> trace;

  GivenSession() {
    attachments.start();
    trace = std::make_unique<TraceWriter>(path, McapMetadata{});
  }
  void announce(SegmentWriter<ClientChannels>& client) {
    server.announce(ClientChannels::id(kClient), client.header().generation,
                    ClientChannels::name(kClient), client.fd());
  }
  TopicCount count() const {
    for (const TopicCount& count : recorder.counts()) {
      if (count.topic == "/client3/given") return count;
    }
    return {};
  }
  /// Drains until as many frames are recorded or counted as lost.
  void drain_until(uint64_t n) {
    REQUIRE(test::serve_until(server, [&] {
      recorder.drain(*trace, now_ns());
      return count().recorded + count().lost == n;
    }));
  }
};

GivenFrame given_frame(uint64_t seq) {
  GivenFrame frame{};
  frame.seq = seq;
  frame.t_ns = now_ns();
  GivenMotion motion{};
  motion.X_WO.p.x = 1.0 / static_cast<double>(seq);
  motion.ticks[0] = 7 * seq;
  frame.moves.resize(seq % 3);
  for (GivenMotion& move : frame.moves) move = motion;
  GivenWrench push{};
  push.wrench.trust_radius = 0.5;
  if (seq % 4 == 0) frame.pushes.push_back(push);
  GivenPlane plane{};
  plane.normal_O = {0, 0, 1};
  plane.feature = seq;
  if (seq % 5 == 0) frame.planes.push_back(plane);
  return frame;
}

std::vector<GivenFrame> publish_given(SegmentWriter<ClientChannels>& client, uint64_t first,
                                      uint64_t n) {
  std::vector<GivenFrame> all;
  for (uint64_t i = 0; i < n; ++i) {
    all.push_back(given_frame(first + i));
    client.channels().frames.publish(all.back());
  }
  return all;
}

}  // namespace

TEST_CASE("recorder: each frame of a client is written once, also of one that comes again") {
  GivenSession session;
  SegmentWriter<ClientChannels> first(1, kClient), second(2, kClient);
  session.announce(first);
  std::vector<GivenFrame> all = publish_given(first, 1, 50);
  session.drain_until(50);
  for (const GivenFrame& frame : publish_given(first, 51, 9)) all.push_back(frame);
  session.announce(second);
  // its numbers begin anew
  for (const GivenFrame& frame : publish_given(second, 1, 40)) all.push_back(frame);
  session.drain_until(99);
  REQUIRE(session.recorder.finish(*session.trace, now_ns()));

  const TraceReader trace(session.path);
  const std::vector<GivenFrame> got = trace.read(given_topic(kClient));
  REQUIRE(got.size() == all.size());
  for (size_t i = 0; i < got.size(); ++i) {
    CHECK((test::bytes_in_use(got[i]) == test::bytes_in_use(all[i])));
  }
  CHECK(trace.mcap().metadata("counts", "/client3/given recorded") == "99");
  CHECK(trace.mcap().metadata("counts", "/client3/given lost") == "0");
  CHECK(trace.topics().size() == kTopics.size() + 1);
}

TEST_CASE("recorder: a client that floods its ring loses its own frames, and they are counted") {
  GivenSession session;
  SegmentWriter<ClientChannels> client(1, kClient);
  session.announce(client);
  publish_given(client, 1, 10);
  session.drain_until(10);
  const uint64_t most = 2 * kSlots + 11;
  publish_given(client, 11, most);
  session.recorder.drain(*session.trace, now_ns());
  // one look at a ring takes no more than a tenth of it
  CHECK(session.count().recorded <= 10 + kSlots / 8);
  REQUIRE(session.recorder.finish(*session.trace, now_ns()));

  const TraceReader trace(session.path);
  uint64_t next = 1, missing = 0;
  for (const GivenFrame& frame : trace.read(given_topic(kClient))) {
    missing += frame.seq - next;
    next = frame.seq + 1;
  }
  CHECK(next == 11 + most);
  CHECK(missing >= most - kSlots);
  CHECK(session.count().lost == missing);
  double told = 0;
  for (const Event& event : trace.read(kEventTopic)) {
    CHECK(event.source == static_cast<uint32_t>(ClientChannels::id(kClient)));
    told += event.numbers[0];
  }
  CHECK(told == static_cast<double>(missing));
}

TEST_CASE("recorder: an instant that a client invents is written as it is, at the present one") {
  GivenSession session;
  SegmentWriter<ClientChannels> client(1, kClient);
  session.announce(client);
  const std::vector<int64_t> lies{std::numeric_limits<int64_t>::min(), -1, 0,
                                  std::numeric_limits<int64_t>::max()};
  const int64_t begin_ns = now_ns();
  for (const int64_t lie : lies) {
    GivenFrame frame = given_frame(1);
    frame.t_ns = lie;
    client.channels().frames.publish(frame);
  }
  session.drain_until(lies.size());
  REQUIRE(session.recorder.finish(*session.trace, now_ns()));
  const TraceReader trace(session.path);
  size_t n = 0;
  trace.for_each<GivenFrame>(given_topic(kClient), [&](const GivenFrame& frame, const Stamp& s) {
    CHECK(frame.t_ns == lies.at(n++));
    CHECK(s.t_ns >= begin_ns - 10 * kNsPerSecond);
    CHECK(s.t_ns <= now_ns());
  });
  CHECK(n == lies.size());
}

}  // namespace haptic
