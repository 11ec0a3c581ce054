// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/library/recorder.h"
#include "clients/log/trace_writer.h"

#include <sys/mount.h>
#include <sys/resource.h>

#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "tests/proto/ipc/served.h"
#include "tests/support/disk/standing_disk.h"
#include "tests/support/frames.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::kPatienceNs;
using test::TemporaryRuntimeFolder;

constexpr uint64_t kServoSlots = decltype(ServoChannels::frames)::kCapacity;

/// A session in this process: hapticd's socket, and a recorder as its client.
struct Session {
  TemporaryRuntimeFolder folder;
  HandoutServer server{"recorded"};
  std::string path;
  std::unique_ptr<Attachments> attachments;
  std::unique_ptr<Recorder> recorder;
  std::unique_ptr<TraceWriter> trace;

  explicit Session(const std::string& where = "") {
    path = (where.empty() ? folder.path() : where) + "/run.mcap";
    attachments = std::make_unique<Attachments>(connect_session("recorded"));
    recorder = std::make_unique<Recorder>(*attachments);
    attachments->start();
    trace = std::make_unique<TraceWriter>(path, McapMetadata{});
  }

  template <typename Channels>
  void announce(SegmentWriter<Channels>& writer) {
    server.announce(Channels::kId, writer.header().generation, Channels::kName, writer.fd());
  }

  /// Serves and drains until the condition holds.
  template <typename Condition>
  bool drain_until(Condition holds) {
    const bool holds_now = test::serve_until(server, [&] {
      if (holds()) return true;
      recorder->drain(*trace, now_ns());
      return false;
    });
    if (!holds_now) return false;
    // a segment may have been attached since: from here on its rings are read
    recorder->drain(*trace, now_ns());
    return true;
  }

  /// A first servo is announced and attached.
  void begin(SegmentWriter<ServoChannels>& servo) {
    announce(servo);
    REQUIRE(drain_until([&] { return recorder->servo_header() != nullptr; }));
  }
  /// The file ends, with the frames of every tick from 0 on.
  void check_all_ticks(uint64_t end) {
    REQUIRE(recorder->finish(*trace, now_ns()));
    uint64_t next = 0;
    for (const ServoFrame& frame : TraceReader(path).read(servo_topic(kFirstHand))) {
      CHECK(frame.tick == next++);
    }
    CHECK(next == end);
    CHECK(lost(0) == 0);
  }

  uint64_t recorded(size_t topic) const { return recorder->counts()[topic].recorded; }
  uint64_t lost(size_t topic) const { return recorder->counts()[topic].lost; }
};

enum TopicIndex : size_t { kServo = 0, kContact = 1, kScene = 2, kControl = 3, kEvents = 4 };

ServoFrame recorded_frame(uint64_t tick) {
  ServoFrame frame{};
  frame.tick = tick;
  frame.t_ns = static_cast<int64_t>(tick) * 1'000'000;
  frame.realtime_ns = frame.t_ns + 5;
  frame.depth = 1.0 / static_cast<double>(tick + 1);
  return frame;
}

void publish(SegmentWriter<ServoChannels>& servo, uint64_t first, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i) servo.channels().frames.publish(recorded_frame(first + i));
}

std::vector<Event> losses_in(const TraceReader& trace) {
  std::vector<Event> out;
  for (const Event& e : trace.read(kEventTopic)) {
    if (e.code == static_cast<uint32_t>(EventCode::kRecordsLost)) out.push_back(e);
  }
  return out;
}

}  // namespace

TEST_CASE("recorder: every ring of the session ends up in the file, bit for bit and in order") {
  Session session;
  SegmentWriter<ServoChannels> servo(1);
  SegmentWriter<ContactChannels> contact(1);
  SegmentWriter<SimChannels> sim(1);
  SegmentWriter<ControlChannels> control(1);
  // control and events are recorded even if they are older than the recording
  ControlFrame wanted{};
  wanted.revision = 9;
  control.channels().frames.publish(wanted);
  servo.channels().events.publish({.t_ns = 4, .code = 1, .source = 2, .numbers = {5, 6, 7, 8, 9}});
  session.announce(servo);
  session.announce(contact);
  session.announce(sim);
  session.announce(control);
  REQUIRE(session.drain_until([&] {
    return session.recorder->servo_header() != nullptr && session.recorded(kControl) == 1 &&
           session.recorded(kEvents) == 1;
  }));

  // the other rings are attached once a first item has arrived
  ContactSet set{};
  set.answers_t_ns = 77;
  SceneFrame scene{};
  scene.objects.resize(2);
  uint64_t sets = 0, scenes = 0;
  REQUIRE(session.drain_until([&] {
    set.seq = ++sets;
    contact.channels().sets.publish(set);
    scene.seq = ++scenes;
    sim.channels().frames.publish(scene);
    return session.recorded(kContact) > 0 && session.recorded(kScene) > 0;
  }));
  publish(servo, 1, 1000);
  REQUIRE(session.drain_until([&] { return session.recorded(kServo) == 1000; }));
  REQUIRE(session.recorder->finish(*session.trace, now_ns()));

  const TraceReader trace(session.path);
  const std::vector<ServoFrame> frames = trace.read(servo_topic(kFirstHand));
  REQUIRE(frames.size() == 1000);
  for (size_t i = 0; i < frames.size(); ++i) {
    CHECK((test::bytes_in_use(frames[i]) == test::bytes_in_use(recorded_frame(i + 1))));
  }
  const std::vector<ContactSet> got = trace.read(contact_topic(kFirstHand));
  REQUIRE_FALSE(got.empty());
  CHECK(got.back().seq == sets);
  for (size_t i = 1; i < got.size(); ++i) CHECK(got[i].seq == got[i - 1].seq + 1);
  CHECK(trace.read(kSimTopic).back().seq == scenes);
  CHECK(trace.read(kControlTopic).at(0).revision == 9);
  CHECK(trace.read(kEventTopic).at(0).numbers == std::array<double, 5>{5, 6, 7, 8, 9});
  CHECK(losses_in(trace).empty());
  trace.for_each<ServoFrame>(servo_topic(kFirstHand), [](const ServoFrame& f, const Stamp& s) {
    CHECK(s.t_ns == f.t_ns);
    CHECK(s.realtime_ns == f.realtime_ns);
    CHECK(s.sequence == f.tick - 1);
  });
  const McapMetadata& counts = trace.mcap().metadata().at("counts");
  CHECK(counts.at("/servo0/frame recorded") == "1000");
  CHECK(counts.at("/servo0/frame lost") == "0");
}

TEST_CASE("recorder: what it was too slow for is counted exactly and is a record of its own") {
  Session session;
  SegmentWriter<ServoChannels> servo(1);
  session.begin(servo);
  publish(servo, 0, 100);
  REQUIRE(session.drain_until([&] { return session.recorded(kServo) == 100; }));
  constexpr uint64_t kBurst = 3 * kServoSlots + 17;
  publish(servo, 100, kBurst);
  REQUIRE(session.drain_until(
      [&] { return session.recorded(kServo) + session.lost(kServo) == 100 + kBurst; }));
  REQUIRE(session.recorder->finish(*session.trace, now_ns()));

  const TraceReader trace(session.path);
  uint64_t missing = 0, next = 0;
  trace.for_each<ServoFrame>(servo_topic(kFirstHand),
                             [&](const ServoFrame& frame, const Stamp& stamp) {
                               missing += frame.tick - next;
                               next = frame.tick + 1;
                               CHECK(stamp.sequence == frame.tick);
                             });
  CHECK(missing == session.lost(kServo));
  CHECK(missing >= kBurst - kServoSlots);
  const std::vector<Event> losses = losses_in(trace);
  REQUIRE(losses.size() == 1);
  CHECK(losses[0].source == static_cast<uint32_t>(servo_segment(kFirstHand)));
  CHECK(losses[0].numbers == std::array<double, 5>{double(missing), double(missing), 1, 0, 0});
}

TEST_CASE("recorder: a disk that stands still for longer than the rings reach loses no record") {
  Session session;
  SegmentWriter<ServoChannels> servo(1);
  session.begin(servo);
  constexpr uint64_t kPart = kServoSlots / 2, kParts = 8;
  {
    test::StandingDisk standing;
    int64_t t_ns = now_ns();
    for (uint64_t part = 0; part < kParts; ++part) {
      publish(servo, part * kPart, kPart);
      // on virtual time, by which chunks are closed
      REQUIRE(session.recorder->drain(*session.trace, t_ns += kNsPerSecond / 4));
    }
    standing.move();
    CHECK_FALSE(standing.was_waited_for());
  }
  session.check_all_ticks(kParts * kPart);
}

TEST_CASE("recorder: it follows a servo that is restarted, without a hole") {
  Session session;
  SegmentWriter<ServoChannels> first(1), second(2);
  session.begin(first);
  publish(first, 0, 500);
  // not drained yet: the last frames of the first writer and those of the second come together
  publish(second, 500, 300);
  session.announce(second);
  REQUIRE(session.drain_until([&] { return session.recorded(kServo) == 800; }));
  session.check_all_ticks(800);
}

TEST_CASE("recorder: a chunk is closed after a quarter of a second, however little is in it") {
  Session session;
  SegmentWriter<ServoChannels> servo(1);
  session.begin(servo);
  publish(servo, 0, 1);
  // on virtual time: drain() is told the time
  int64_t t_ns = now_ns() + kPatienceNs;
  REQUIRE(session.recorder->drain(*session.trace, t_ns));
  const uint64_t with_first = session.trace->size();
  publish(servo, 1, 1);
  REQUIRE(session.recorder->drain(*session.trace, t_ns += kNsPerSecond / 4 - 1));
  CHECK(session.trace->size() == with_first);
  REQUIRE(session.recorder->drain(*session.trace, t_ns += 1));
  CHECK(session.trace->size() > with_first);
  // a reader sees it although the file has no end yet
  CHECK(session.drain_until(
      [&] { return TraceReader(session.path).read(servo_topic(kFirstHand)).size() == 2; }));
}

namespace {

/// An incompressible frame.
ServoFrame noisy_frame(uint64_t tick) {
  ServoFrame frame = recorded_frame(tick);
  std::mt19937_64 random(tick);
  frame.pushes.resize(16);
  for (ObjectPush& push : frame.pushes) {
    Wrench& impulse = push.impulse_W;
    for (double* part : {&impulse.f.x, &impulse.f.y, &impulse.f.z, &impulse.t.x}) {
      *part = std::bit_cast<double>(random() >> 2);
    }
  }
  return frame;
}

/// Publishes until a write error ends the file, and beyond; finishes it and checks the counts.
void check_counts_of_what_is_full(Session& session, SegmentWriter<ServoChannels>& servo) {
  uint64_t published = 0;
  bool good = true;
  while (good && published < 20'000) {
    for (int i = 0; i < 50; ++i) servo.channels().frames.publish(noisy_frame(published++));
    good = session.recorder->drain(*session.trace, now_ns());
  }
  CHECK_FALSE((good && session.trace->flush()));
  // everything that arrives before the recorder ends is lost too
  for (int i = 0; i < 7; ++i) servo.channels().frames.publish(noisy_frame(published++));
  CHECK_FALSE(session.recorder->finish(*session.trace, now_ns()));

  const TraceReader trace(session.path);
  CHECK(trace.mcap().finished());
  const uint64_t there = trace.read(servo_topic(kFirstHand)).size();
  CHECK(there > 0);
  CHECK(session.recorded(kServo) == there);
  CHECK(session.lost(kServo) == published - there);
  CHECK_THAT(
      session.recorder->failure(),
      Catch::StartsWith(session.path + ": ") &&
          Catch::EndsWith("; lost: " + std::to_string(published - there) + " of /servo0/frame"));
}

}  // namespace

TEST_CASE("recorder: at a limit of the file size what is not in the file is counted as lost") {
  Session session;
  SegmentWriter<ServoChannels> servo(1);
  session.begin(servo);
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  // as set by `ulimit -f`; the writer checks it before the kernel sends a signal
  const rlimit small{1'000'000, before.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  check_counts_of_what_is_full(session, servo);
  REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
}

TEST_CASE("recorder: on a full disk what is not in the file is counted as lost") {
  const test::TemporaryFolder folder;
  const std::string disk = folder.path() + "/disk";
  std::filesystem::create_directory(disk);
  if (mount("none", disk.c_str(), "tmpfs", 0, "size=1m") != 0) {
    WARN("SKIPPED: mounting a small disk needs root");
    return;
  }
  {
    Session session(disk);
    SegmentWriter<ServoChannels> servo(1);
    session.begin(servo);
    check_counts_of_what_is_full(session, servo);
  }
  CHECK(umount(disk.c_str()) == 0);
}

}  // namespace haptic
