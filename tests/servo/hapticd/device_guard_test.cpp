// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/device_guard.cpp with a serial line, a segment and a process of the test.
#include "servo/hapticd/device_guard.h"
#include "proto/ipc/handout_server.h"

#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>

#include "proto/config/devices.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"
#include "tests/support/pty_line.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr std::string_view kZero = "no force\n";

/// A process that waits until it is killed, in place of the servo: only its pidfd matters.
class Idler {
 public:
  Idler() : pid_(fork()) {
    if (pid_ == 0) {
      for (;;) pause();
    }
    pidfd_ = FileDescriptor(static_cast<int>(syscall(SYS_pidfd_open, pid_, 0)));
  }
  ~Idler() { end(); }
  Idler(const Idler&) = delete;

  int pidfd() const { return pidfd_.get(); }
  void end() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    pid_ = -1;
  }

 private:
  pid_t pid_;
  FileDescriptor pidfd_;
};

/// A session in this process: hapticd's socket, a servo's segment, and a guard on a line.
struct Bench {
  test::TemporaryRuntimeFolder folder;
  Idler servo;  // created before the line, which it would otherwise inherit
  test::PtyLine line;
  HandoutServer server{"guarded"};
  SegmentWriter<ServoChannels> segment{1};
  std::unique_ptr<Attachments> attachments =
      std::make_unique<Attachments>(connect_session("guarded"));
  RingSource<& ServoChannels::releases> seen =
      attachments->ring<&ServoChannels::releases>(Start::kOldest);
  SessionConfig config{};
  std::string link = folder.path() + "/device";
  std::unique_ptr<DeviceGuard> guard;

  Bench() {
    config.device.kind = DeviceKind::kWoodenHaptics;
    std::filesystem::create_symlink(line.name(), link);
    assign(config.device.serial.path, link);
    guard = std::make_unique<DeviceGuard>(config, *attachments);
    attachments->start();
    DeviceRelease release{};
    release.by = static_cast<uint32_t>(ReleaseBy::kWrite);
    release.size = kZero.size();
    kZero.copy(release.bytes.data(), kZero.size());
    segment.channels().releases.publish(release);
    segment.beat(0, now_ns());
    segment.set_state(SegmentState::kRun);
    server.announce(servo_segment(kFirstHand), 1, ServoChannels::kName, segment.fd());
    guard->start();
    guard->watch(servo.pidfd(), 1);
    // until the segment is mapped the release bytes are unknown
    DeviceRelease got;
    beat_until([&] { return seen.latest(got); });
    beat_for(20 * kMs);
  }

  template <typename Condition>
  void beat_until(Condition holds) {
    while (!holds()) {
      server.serve({});
      segment.beat(0, now_ns());
      sleep_until(now_ns() + kMs);
    }
  }
  void beat_for(int64_t span_ns) {
    const int64_t end_ns = now_ns() + span_ns;
    beat_until([&] { return now_ns() > end_ns; });
  }
};

int times(const std::string& text) {
  int n = 0;
  for (size_t at = 0; (at = text.find(kZero, at)) != std::string::npos; at += kZero.size()) ++n;
  return n;
}

/// Everything received within a tenth of a second.
std::string hear_all(const test::PtyLine& line) {
  std::string text = line.hear();
  for (std::string more; !(more = line.hear(100)).empty();) text += more;
  return text;
}

}  // namespace

TEST_CASE("device guard: a release is sent at once and three times more, 5 ms apart", "[servo]") {
  ReleaseSchedule schedule;
  int sent = 0;
  CHECK_FALSE(schedule.is_due(false, 0));
  for (int64_t t_ns = 10 * kMs; t_ns < 100 * kMs; t_ns += kMs) {
    if (!schedule.is_due(true, t_ns)) continue;
    CHECK(t_ns == 10 * kMs + sent * ReleaseSchedule::kApartNs);
    ++sent;
  }
  CHECK(sent == ReleaseSchedule::kTimes);
  CHECK_FALSE(schedule.is_due(false, 100 * kMs));
  CHECK(schedule.is_due(true, 101 * kMs));
}

TEST_CASE("device guard: a servo that dies is answered with its own bytes for no force",
          "[servo]") {
  Bench b;
  b.line.hear(0);
  b.servo.end();
  // heartbeats do not help a dead process
  b.beat_for(100 * kMs);
  CHECK(times(hear_all(b.line)) >= 1);
  CHECK(b.guard->releases() >= 1);
}

TEST_CASE("device guard: a servo that stands still is let go, and again after it went on",
          "[servo]") {
  Bench b;
  // a busy machine may have delayed the heartbeats
  b.line.hear(0);
  CHECK(times(hear_all(b.line)) >= 1);
  // a guard that has not run in the meantime has not seen it recover
  int again = 0;
  for (int attempt = 0; attempt < 5 && again == 0; ++attempt) {
    b.beat_for(20 * kMs);
    b.line.hear(0);
    again = times(hear_all(b.line));
  }
  CHECK(again >= 1);
}

TEST_CASE("device guard: a servo that has stopped in order, or not yet begun, is left alone",
          "[servo]") {
  Bench b;
  b.segment.set_state(GENERATE(SegmentState::kInit, SegmentState::kDead));
  sleep_until(now_ns() + 20 * kMs);
  hear_all(b.line);
  CHECK(b.line.hear(100).empty());
}

TEST_CASE("device guard: a device that is pulled out is noticed, and found when it is back",
          "[servo]") {
  Bench b;
  CHECK(b.guard->look(now_ns()) == DeviceGuard::Change::kNone);
  CHECK(b.guard->node() >= 0);
  b.line.unplug();
  CHECK(b.guard->look(now_ns()) == DeviceGuard::Change::kGone);
  CHECK(b.guard->node() == -1);
  CHECK(b.guard->look(now_ns()) == DeviceGuard::Change::kNone);
  // back under another number, found by its stable name
  const test::PtyLine again;
  std::filesystem::remove(b.link);
  std::filesystem::create_symlink(again.name(), b.link);
  CHECK(b.guard->look(now_ns() + kNsPerSecond) == DeviceGuard::Change::kBack);
  CHECK(b.guard->node() >= 0);
  again.hear(0);
  CHECK(times(hear_all(again)) >= 1);
}

TEST_CASE("device guard: a node that is not there is one line with what to do", "[servo]") {
  const test::TemporaryRuntimeFolder folder;
  const HandoutServer server("guarded");
  Attachments attachments(connect_session("guarded"));
  SessionConfig config{};
  config.device.kind = DeviceKind::kWoodenHaptics;
  assign(config.device.serial.path, folder.path() + "/nothing");
  CHECK_THROWS_WITH(DeviceGuard(config, attachments), Catch::Contains("plug the device in"));
}

}  // namespace haptic
