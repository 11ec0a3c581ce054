// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace haptic {
namespace {

using Bytes = std::vector<std::byte>;

/// What a writer of generation 3 with one frame left in memory.
Bytes valid_image() {
  SegmentWriter<SimChannels> writer(3);
  SceneFrame frame{};
  frame.seq = 77;
  writer.channels().frames.publish(frame);
  Bytes image(kSegmentSpec<SimChannels>.total_bytes);
  REQUIRE(pread(writer.fd(), image.data(), image.size(), 0) == ssize_t(image.size()));
  return image;
}

FileDescriptor file_with(const Bytes& image, int seals = F_SEAL_SHRINK) {
  FileDescriptor fd(memfd_create("image", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  REQUIRE(write(fd.get(), image.data(), image.size()) == ssize_t(image.size()));
  if (seals != 0) REQUIRE(fcntl(fd.get(), F_ADD_SEALS, seals) == 0);
  return fd;
}

/// The fault of an attempt to read a file; none: it was accepted.
template <typename Channels = SimChannels>
std::optional<SegmentFault> fault_of(FileDescriptor fd, const ViewOptions& options = {}) {
  try {
    const SegmentView<Channels> view(std::move(fd), options);
    return std::nullopt;
  } catch (const SegmentError& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    CHECK(std::string(error.what()).find(Channels::kName) != std::string::npos);
    return error.fault;
  }
}

template <typename Value>
Bytes patched(Bytes image, size_t offset, Value value) {
  std::memcpy(image.data() + offset, &value, sizeof value);
  return image;
}

constexpr size_t kFirstEntry = offsetof(SegmentHeader, channels);

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
  CHECK(view.header().process_start == process_start_time(uint64_t(getpid())));
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
  CHECK(process_start_time(1) <= process_start_time(uint64_t(getpid())));
  CHECK(process_start_time(uint64_t{1} << 40) == 0);
}

TEST_CASE("segment: an unharmed copy of a segment is accepted") {
  CHECK_FALSE(fault_of(file_with(valid_image())).has_value());
}

TEST_CASE("segment: each kind of damage is refused by its name") {
  const Bytes good = valid_image();
  using H = SegmentHeader;
  const auto refused = [&](size_t offset, auto value) {
    return fault_of(file_with(patched(good, offset, value)));
  };
  CHECK(fault_of(file_with({})) == SegmentFault::kTooShort);
  CHECK(fault_of(file_with(Bytes(good.begin(), good.begin() + 100))) == SegmentFault::kTooShort);
  CHECK(fault_of(file_with(Bytes(good.begin(), good.end() - 1))) == SegmentFault::kTooShort);
  CHECK(fault_of(file_with(good, 0)) == SegmentFault::kNotSealed);
  CHECK(fault_of(FileDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC))) ==
        SegmentFault::kNotSealed);
  CHECK(refused(offsetof(H, magic), kSegmentMagic + 1) == SegmentFault::kWrongMagic);
  CHECK(refused(offsetof(H, magic), uint64_t{0}) == SegmentFault::kNotReady);
  CHECK(refused(offsetof(H, abi_major), kAbiMajor + 1) == SegmentFault::kWrongAbi);
  CHECK(refused(offsetof(H, layout_hash), uint64_t{1}) == SegmentFault::kWrongLayout);
  CHECK(refused(offsetof(H, segment_id), uint32_t{2}) == SegmentFault::kWrongKind);
  CHECK(refused(offsetof(H, total_bytes), uint64_t{1} << 40) == SegmentFault::kTooShort);
  CHECK(refused(offsetof(H, n_channels), uint32_t{1000}) == SegmentFault::kWrongTable);
  const size_t offset = kFirstEntry + offsetof(ChannelEntry, offset);
  for (const uint64_t huge : {~uint64_t{0}, ~uint64_t{0} - 63, uint64_t{1} << 40, uint64_t{0}}) {
    CAPTURE(huge);
    CHECK(refused(offset, huge) == SegmentFault::kWrongTable);
  }
  CHECK(refused(kFirstEntry + offsetof(ChannelEntry, bytes), ~uint64_t{0}) ==
        SegmentFault::kWrongTable);
}

TEST_CASE("segment: another process's segment is refused even when it is large enough") {
  SegmentWriter<ServoChannels> writer(1);
  CHECK(fault_of<SimChannels>(reopen_read_only(writer.fd())) == SegmentFault::kWrongKind);
}

TEST_CASE("segment: any flipped byte of the identity or the table is refused, none crashes") {
  const Bytes good = valid_image();
  constexpr size_t kTableEnd = kFirstEntry + 2 * sizeof(ChannelEntry);
  for (size_t at = 0; at < sizeof(SegmentHeader); ++at) {
    const auto fault = fault_of(file_with(patched(good, at, good[at] ^ std::byte{0x41})));
    const bool identity =
        at < offsetof(SegmentHeader, abi_minor) ||
        (at >= offsetof(SegmentHeader, layout_hash) && at < offsetof(SegmentHeader, generation)) ||
        (at >= offsetof(SegmentHeader, clock_id) &&
         at < offsetof(SegmentHeader, clock_id) + sizeof(SegmentHeader::clock_id));
    const bool table = at >= kFirstEntry && at < kTableEnd;
    CAPTURE(at);
    CHECK(fault.has_value() == (identity || table));
  }
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

TEST_CASE("segment: nobody but the writer can change, shrink or punch a published segment") {
  SegmentWriter<ControlChannels> writer(1);
  ControlFrame frame{};
  frame.revision = 9;
  writer.channels().frames.publish(frame);
  const size_t bytes = kSegmentSpec<ControlChannels>.total_bytes;

  // opening for writing succeeds even so: what counts is that nothing can be done with it
  const std::string path = "/proc/self/fd/" + std::to_string(writer.fd());
  const FileDescriptor hostile(open(path.c_str(), O_RDWR | O_CLOEXEC));
  REQUIRE(hostile.is_open());
  CHECK(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, hostile.get(), 0) == MAP_FAILED);
  CHECK(errno == EPERM);
  const char junk[64] = {1};
  CHECK(pwrite(hostile.get(), junk, sizeof junk, 0) == -1);
  CHECK(errno == EPERM);
  CHECK(ftruncate(hostile.get(), 0) == -1);
  CHECK(errno == EPERM);
  CHECK(ftruncate(hostile.get(), off_t(2 * bytes)) == -1);
  CHECK(errno == EPERM);
  CHECK(fallocate(hostile.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096) == -1);
  CHECK(errno == EPERM);
  CHECK(fcntl(hostile.get(), F_ADD_SEALS, F_SEAL_WRITE) == -1);

  const FileDescriptor reader = reopen_read_only(writer.fd());
  CHECK(pwrite(reader.get(), junk, sizeof junk, 0) == -1);
  void* mapped = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, reader.get(), 0);
  REQUIRE(mapped != MAP_FAILED);
  CHECK(mprotect(mapped, bytes, PROT_READ | PROT_WRITE) == -1);
  munmap(mapped, bytes);

  // the data is what it was, and the writer itself goes on
  const SegmentView<ControlChannels> view(reopen_read_only(writer.fd()));
  ControlFrame out;
  REQUIRE(view.channels().frames.latest(out));
  CHECK(out.revision == 9);
  frame.revision = 10;
  writer.channels().frames.publish(frame);
  REQUIRE(view.channels().frames.latest(out));
  CHECK(out.revision == 10);
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
