// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/ipc/segment.h"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <limits>
#include <string>
#include <thread>

#include "proto/os/programs.h"
#include "tests/proto/ipc/segment_image.h"

namespace haptic {
namespace {

using test::Bytes;
using test::fault_of;
using test::file_with;
using test::valid_image;

}  // namespace

TEST_CASE("segment: the hash is FNV-1a, as its authors' test vectors say") {
  static_assert(fnv1a("") == 0xcbf29ce484222325);
  static_assert(fnv1a("a") == 0xaf63dc4c8601ec8c);
  static_assert(fnv1a("foobar") == 0x85944171f73967e8);
  CHECK(fnv1a(uint64_t{0x7261'626f'6f66}, fnv1a("")) == fnv1a(std::string_view("foobar\0\0", 8)));
}

TEST_CASE("segment: no two kinds share a layout hash") {
  CHECK(kSegmentSpec<ServoChannels>.layout_hash != kSegmentSpec<ContactChannels>.layout_hash);
  CHECK(kSegmentSpec<SimChannels>.layout_hash != kSegmentSpec<ControlChannels>.layout_hash);
  CHECK(record_hash<ServoFrame>() != record_hash<SceneFrame>());
}

TEST_CASE("segment: a reader sees what the writer published, then and later") {
  SegmentWriter<SimChannels> writer(5);
  SceneFrame frame{};
  frame.seq = 1;
  writer.channels().frames.publish(frame);
  const SegmentView<SimChannels> view(reopen_read_only(writer.fd()));
  SceneFrame out;
  REQUIRE(view.channels().frames.latest(out));
  CHECK(out.seq == 1);
  frame.seq = 2;
  writer.channels().frames.publish(frame);
  REQUIRE(view.channels().frames.latest(out));
  CHECK(out.seq == 2);
  CHECK(view.generation() == 5);
}

TEST_CASE("segment: the header tells who writes and whether it is alive") {
  SegmentWriter<ControlChannels> writer(1);
  const SegmentView<ControlChannels> view(reopen_read_only(writer.fd()));
  CHECK(view.header().pid == uint64_t(getpid()));
  CHECK(view.header().process_start == start_time_of(getpid()));
  CHECK(view.header().process_start > 0);
  CHECK(view.header().state == uint32_t(SegmentState::kInit));
  writer.set_state(SegmentState::kRun);
  writer.beat(41, 123456);
  RealtimeReport report;
  report.bits = kRealtimeWanted;
  report.fifo_errno = EPERM;
  writer.set_realtime(report);
  CHECK(view.header().state == uint32_t(SegmentState::kRun));
  CHECK(view.header().heartbeat == 41);
  CHECK(view.header().heartbeat_ns == 123456);
  CHECK(view.header().realtime_bits == kRealtimeWanted);
  CHECK(view.header().fifo_errno == EPERM);
}

TEST_CASE("segment: the start of a process tells it from one that reuses its number") {
  CHECK(start_time_of(1) <= start_time_of(getpid()));
  CHECK(start_time_of(std::numeric_limits<pid_t>::max()) == 0);
}

TEST_CASE("segment: an unharmed copy of a segment is accepted") {
  CHECK_FALSE(fault_of(file_with(valid_image())).has_value());
}

TEST_CASE("segment: what is not sealed is refused, and a writer that was never ready") {
  Bytes image = valid_image();
  CHECK(fault_of(file_with(image, 0)) == SegmentFault::kNotSealed);
  std::fill_n(image.begin() + offsetof(SegmentHeader, magic), sizeof(uint64_t), std::byte{0});
  CHECK(fault_of(file_with(image)) == SegmentFault::kNotReady);
}

TEST_CASE("segment: another process's segment is refused even when it is large enough") {
  SegmentWriter<ContactChannels> writer(1);
  CHECK(fault_of<SimChannels>(reopen_read_only(writer.fd())) == SegmentFault::kWrongKind);
}

TEST_CASE("segment: a reader waits for a writer that is not ready yet, but not for ever") {
  WritableSegment writer(kSegmentSpec<SimChannels>, 1);
  CHECK(fault_of(reopen_read_only(writer.fd()), {.ready_timeout_ns = 1'000'000}) ==
        SegmentFault::kNotReady);
  std::thread publisher([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    writer.publish();
  });
  CHECK_FALSE(
      fault_of(reopen_read_only(writer.fd()), {.ready_timeout_ns = 60 * kNsPerSecond}).has_value());
  publisher.join();
}

TEST_CASE("segment: a sealed file keeps its bytes") {
  const Bytes bytes(1000, std::byte{42});
  const FileDescriptor fd = make_sealed_file("config", bytes);
  CHECK(pwrite(fd.get(), "x", 1, 0) == -1);
  CHECK(ftruncate(fd.get(), 10) == -1);
  Bytes out(2000);
  REQUIRE(pread(fd.get(), out.data(), out.size(), 0) == 1000);
  out.resize(1000);
  CHECK(out == bytes);
}

}  // namespace haptic
