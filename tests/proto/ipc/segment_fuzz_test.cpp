// SPDX-License-Identifier: GPL-3.0-or-later
// A reader of a damaged segment reports a named error; it never crashes or hangs.
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <thread>

#include "proto/ipc/ring_source.h"
#include "tests/proto/ipc/segment_image.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::Bytes;
using test::fault_of;
using test::file_with;
using test::valid_image;
using Header = SegmentHeader;

constexpr size_t kTotal = kSegmentSpec<SimChannels>.total_bytes;
constexpr size_t kRings = offsetof(SegmentLayout<SimChannels>, channels);

/// A segment whose bytes can be changed and restored under its readers.
class PatchedSegment {
 public:
  PatchedSegment() : image_(valid_image()), fd_(file_with(image_)) {}

  void write(size_t at, const void* bytes, size_t count) {
    REQUIRE(pwrite(fd_.get(), bytes, count, off_t(at)) == ssize_t(count));
  }
  std::optional<SegmentFault> fault() const { return fault_of(reopen_read_only(fd_.get())); }

  /// Temporarily replaces its bytes by these.
  std::optional<SegmentFault> fault_with(size_t at, const void* bytes, size_t count) {
    write(at, bytes, count);
    const auto found = fault();
    write(at, &image_[at], count);
    return found;
  }
  template <typename Value>
  std::optional<SegmentFault> fault_with(size_t at, Value value) {
    return fault_with(at, &value, sizeof value);
  }
  const Bytes& image() const { return image_; }
  int fd() const { return fd_.get(); }

 private:
  Bytes image_;
  FileDescriptor fd_;
};

/// The error expected for a header in which that byte is wrong; none for a byte that may have any
/// value (writer identity, state of its loop, unused).
std::optional<SegmentFault> fault_of_byte(size_t at) {
  const auto in = [at](size_t begin, size_t size) { return at >= begin && at < begin + size; };
  if (in(offsetof(Header, magic), 8)) return SegmentFault::kWrongMagic;
  if (in(offsetof(Header, abi_major), 4)) return SegmentFault::kWrongAbi;
  if (in(offsetof(Header, clock_id), 8)) return SegmentFault::kWrongAbi;
  if (in(offsetof(Header, layout_hash), 8)) return SegmentFault::kWrongLayout;
  if (in(offsetof(Header, total_bytes), 8)) return SegmentFault::kTooShort;
  if (in(offsetof(Header, segment_id), 4)) return SegmentFault::kWrongKind;
  return std::nullopt;
}

constexpr uint64_t kOddNumbers[] = {0,
                                    1,
                                    63,
                                    kTotal - 1,
                                    kTotal + 1,
                                    uint64_t{1} << 31,
                                    uint64_t{1} << 32,
                                    uint64_t{1} << 40,
                                    uint64_t{1} << 63,
                                    ~uint64_t{0} - kTotal,
                                    ~uint64_t{0} - 63,
                                    ~uint64_t{0}};

}  // namespace

TEST_CASE("segment fuzz: each byte of the header flipped is refused by the name of its field") {
  PatchedSegment segment;
  // the first alone of a byte that may have any value: what is accepted takes its time
  constexpr std::array kMasks{0xffu, 1u, 2u, 4u, 8u, 16u, 32u, 64u, 128u, 0x55u};
  for (size_t at = 0; at < sizeof(Header); ++at) {
    const size_t n = fault_of_byte(at).has_value() ? kMasks.size() : 1;
    for (const unsigned mask : std::span(kMasks).first(n)) {
      const auto fault = segment.fault_with(at, segment.image()[at] ^ std::byte(mask));
      if (fault == fault_of_byte(at)) continue;
      CAPTURE(at, mask);
      CHECK(fault == fault_of_byte(at));
    }
  }
  CHECK_FALSE(segment.fault().has_value());
}

TEST_CASE("segment fuzz: a header of random damage is accepted only where no field is touched") {
  PatchedSegment segment;
  std::mt19937_64 random(23);
  // the thread sanitizer takes 20 ms for each mapping
  constexpr int kRounds = test::kSlowdown > 1 ? 1000 : 4000;
  uint64_t accepted = 0;
  for (int round = 0; round < kRounds; ++round) {
    Bytes header(segment.image().begin(), segment.image().begin() + sizeof(Header));
    bool is_harmed = false;
    for (uint64_t left = 1 + random() % (round % 10 == 0 ? 640 : 3); left > 0; --left) {
      const size_t at = random() % header.size();
      header[at] = std::byte(random());
      is_harmed = is_harmed || fault_of_byte(at).has_value();
    }
    const bool is_same = [&] {
      for (size_t at = 0; at < header.size(); ++at) {
        if (fault_of_byte(at) && header[at] != segment.image()[at]) return false;
      }
      return true;
    }();
    const auto fault = segment.fault_with(0, header.data(), header.size());
    accepted += !fault.has_value();
    if (fault.has_value() == !is_same) continue;
    CAPTURE(round);
    CHECK(fault.has_value() == !is_same);
  }
  CHECK(accepted > kRounds / 20);
  CHECK(accepted < kRounds - kRounds / 20);
}

TEST_CASE("segment fuzz: a file cut at any interesting length is too short") {
  const Bytes good = valid_image();
  std::set<size_t> lengths{kTotal - 1, kTotal - 8, kTotal - 64, kTotal / 2};
  for (size_t length = 0; length <= sizeof(Header); ++length) {
    lengths.insert(length);
  }
  for (size_t page = 4096; page < kTotal; page += 4096) {
    for (const size_t length : {page - 1, page, page + 1}) lengths.insert(length);
  }
  for (const uint64_t edge : {kRings, kRings + offsetof(SimChannels, events), kTotal}) {
    for (const size_t length : {edge - 1, edge, edge + 1}) {
      if (length < kTotal) lengths.insert(length);
    }
  }
  // what lies behind the header says nothing of its length: holes, which take no time to write
  for (const size_t length : lengths) {
    FileDescriptor cut(memfd_create("image", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    const size_t head = std::min(length, sizeof(Header));
    REQUIRE(write(cut.get(), good.data(), head) == ssize_t(head));
    REQUIRE(ftruncate(cut.get(), off_t(length)) == 0);
    REQUIRE(fcntl(cut.get(), F_ADD_SEALS, F_SEAL_SHRINK) == 0);
    const auto fault = fault_of(std::move(cut));
    if (fault == SegmentFault::kTooShort) continue;
    CAPTURE(length);
    CHECK(fault == SegmentFault::kTooShort);
  }
}

TEST_CASE("segment fuzz: older and newer interfaces are refused, a newer minor one is not") {
  PatchedSegment segment;
  for (const uint32_t major : {kAbiMajor - 1, kAbiMajor + 1, 0u, ~0u}) {
    CAPTURE(major);
    CHECK(segment.fault_with(offsetof(Header, abi_major), major) == SegmentFault::kWrongAbi);
  }
  CHECK_FALSE(segment.fault_with(offsetof(Header, abi_minor), kAbiMinor + 1).has_value());
}

TEST_CASE("segment fuzz: no claimed size leads a reader out of the segment") {
  PatchedSegment segment;
  for (const uint64_t value : kOddNumbers) {
    CAPTURE(value);
    CHECK(segment.fault_with(offsetof(Header, total_bytes), value) == SegmentFault::kTooShort);
  }
}

TEST_CASE("segment fuzz: what is no segment at all is refused") {
  int ends[2];
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  const FileDescriptor other_end(ends[1]);
  CHECK(fault_of(FileDescriptor(ends[0])) == SegmentFault::kNotSealed);
  for (const char* path : {"/dev/zero", "/dev/null", "/proc/self/exe", "/"}) {
    CAPTURE(path);
    CHECK(fault_of(FileDescriptor(open(path, O_RDONLY | O_CLOEXEC))) == SegmentFault::kNotSealed);
  }
  CHECK(fault_of(FileDescriptor(-1)) == SegmentFault::kNotSealed);
}

TEST_CASE("segment fuzz: a header that changes while it is checked does not crash its reader") {
  PatchedSegment segment;
  std::atomic<bool> done{false};
  std::thread vandal([&] {
    std::mt19937_64 random(29);
    while (!done) {
      const size_t at = random() % sizeof(Header);
      const std::byte byte = segment.image()[at] ^ std::byte(random() % 2 == 0 ? 0 : random());
      if (pwrite(segment.fd(), &byte, 1, off_t(at)) != 1) return;
      if (random() % 4 == 0 && pwrite(segment.fd(), segment.image().data(), sizeof(Header), 0) < 0)
        return;
    }
  });
  uint64_t refused = 0;
  for (int round = 0; round < 1000; ++round) refused += segment.fault().has_value();
  done = true;
  vandal.join();
  CHECK(refused > 0);
}

TEST_CASE("segment fuzz: whatever lies in a ring, a reader of it comes to an end") {
  PatchedSegment segment;
  std::mt19937_64 random(31);
  using RingType = decltype(SimChannels::frames);
  const SegmentView<SimChannels> view(reopen_read_only(segment.fd()));
  const RingType& ring = view.channels().frames;
  const size_t at = kRings + offsetof(SimChannels, frames);
  std::vector<uint64_t> words(sizeof(RingType) / 8);
  for (int round = 0; round < 200; ++round) {
    // sometimes similar tickets, so that some items look complete
    const uint64_t span = round % 2 == 0 ? std::numeric_limits<uint64_t>::max() : 1024;
    for (uint64_t& word : words) word = random() % span;
    const uint64_t n = kOddNumbers[static_cast<size_t>(round) % std::size(kOddNumbers)];
    words[0] = round % 3 == 0 ? n : words[0];
    segment.write(at, words.data(), words.size() * 8);
    SceneFrame out;
    Cursor living{random() % span, 0}, dead = living;
    uint64_t looks = 0;
    while (read_next(ring, living, out)) ++looks;
    while (read_final(ring, dead, out)) ++looks;
    ring.prefetch_newest();
    ring.latest(out);
    CHECK(looks <= 2 * RingType::kCapacity);
  }
}

}  // namespace haptic
