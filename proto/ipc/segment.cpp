// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "proto/math/assert.h"
#include "proto/os/programs.h"

// in <linux/fcntl.h>, which cannot be included next to <fcntl.h>
#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

namespace haptic {
namespace {

namespace bip = boost::interprocess;

constexpr int64_t kReadyPollNs = 100'000;  // between checks for the magic number

/// Adapter of a memfd for Boost.Interprocess.
struct MemfdObject {
  int fd;
  bip::mode_t mode;
  bip::mapping_handle_t get_mapping_handle() const { return {fd, false}; }
  bip::mode_t get_mode() const { return mode; }
};

[[noreturn]] void throw_system(const std::string& what) {
  throw SegmentError(SegmentFault::kSystem, what + ": " + std::strerror(errno));
}

bip::mapped_region map_all(int fd, bip::mode_t mode, size_t bytes) {
  try {
    return bip::mapped_region(MemfdObject{fd, mode}, mode, 0, bytes);
  } catch (const bip::interprocess_exception& error) {
    throw SegmentError(SegmentFault::kSystem, std::string("cannot map a segment: ") + error.what());
  }
}

FileDescriptor make_memfd(const std::string& name, size_t bytes) {
  FileDescriptor fd(memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!fd.is_open()) throw_system("cannot create segment '" + name + "'");
  if (ftruncate(fd.get(), static_cast<off_t>(bytes)) != 0) {
    throw_system("cannot size segment '" + name + "' to " + std::to_string(bytes) + " bytes");
  }
  return fd;
}

void add_seals(int fd, int seals) {
  if (fcntl(fd, F_ADD_SEALS, seals) != 0) throw_system("cannot seal a segment");
}

/// Checks of one reader; each message names the segment.
class Validation {
 public:
  explicit Validation(const SegmentSpec& spec) : spec_(spec) {}

  void require(bool ok, SegmentFault fault, const std::string& what) const {
    if (!ok) throw SegmentError(fault, std::string("segment '") + spec_.name + "': " + what);
  }

  void check_file(int fd) const {
    // an unsealed file could be shrunk by the writer: SIGBUS in the reader
    const int seals = fcntl(fd, F_GET_SEALS);
    require(seals >= 0 && (seals & F_SEAL_SHRINK) != 0, SegmentFault::kNotSealed,
            "its size is not sealed; only segments made by hapticd's processes can be attached");
    struct stat status {};
    require(fstat(fd, &status) == 0, SegmentFault::kSystem, std::strerror(errno));
    require(std::cmp_greater_equal(status.st_size, spec_.total_bytes), SegmentFault::kTooShort,
            std::to_string(status.st_size) + " bytes, expected " +
                std::to_string(spec_.total_bytes) + "; " + kRebuild);
  }

  void check_magic(const SegmentHeader& header, int64_t timeout_ns) const {
    const int64_t deadline_ns = now_ns() + timeout_ns;
    uint64_t magic = header.magic.load(std::memory_order_acquire);
    while (magic == 0 && now_ns() < deadline_ns) {
      sleep_until(now_ns() + kReadyPollNs);
      magic = header.magic.load(std::memory_order_acquire);
    }
    require(magic != 0, SegmentFault::kNotReady, "its writer did not finish preparing it in time");
    require(magic == kSegmentMagic, SegmentFault::kWrongMagic, "this is not a segment of hapticd");
  }

  void check_header(const SegmentHeader& header) const {
    const uint32_t abi = header.abi_major.load(std::memory_order_relaxed);
    require(abi == kAbiMajor, SegmentFault::kWrongAbi,
            "version " + std::to_string(abi) + " of the interface, this program speaks " +
                std::to_string(kAbiMajor) + "; " + kRebuild);
    require(header.segment_id.load(std::memory_order_relaxed) == static_cast<uint32_t>(spec_.id),
            SegmentFault::kWrongKind, "its header names another process");
    require(header.layout_hash.load(std::memory_order_relaxed) == spec_.layout_hash,
            SegmentFault::kWrongLayout,
            std::string("its records are laid out differently; ") + kRebuild);
    require(header.total_bytes.load(std::memory_order_relaxed) == spec_.total_bytes,
            SegmentFault::kTooShort, "its header claims another size than its records need");
    require(header.clock_id.load(std::memory_order_relaxed) == CLOCK_MONOTONIC,
            SegmentFault::kWrongAbi, std::string("its times are of another clock; ") + kRebuild);
  }

 private:
  static constexpr const char* kRebuild =
      "build all programs of the session from the same source and restart it";
  const SegmentSpec& spec_;
};

}  // namespace

RealtimeReport realtime_of(const SegmentHeader& header) noexcept {
  return {.bits = header.realtime_bits.load(),
          .fifo_errno = header.fifo_errno.load(),
          .memory_errno = header.memory_errno.load()};
}

FileDescriptor reopen_read_only(int fd) {
  HAPTIC_ASSERT(fd >= 0);
  const std::string path = "/proc/self/fd/" + std::to_string(fd);
  FileDescriptor copy(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!copy.is_open()) throw_system("cannot open a segment for reading");
  return copy;
}

FileDescriptor make_sealed_file(const char* name, std::span<const std::byte> bytes) {
  FileDescriptor fd = make_memfd(name, bytes.size());
  if (write(fd.get(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
    throw_system(std::string("cannot fill '") + name + "'");
  }
  add_seals(fd.get(), F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL);
  return fd;
}

WritableSegment::WritableSegment(const SegmentSpec& spec, uint64_t generation)
    : fd_(make_memfd(std::string("haptic-") + spec.name, spec.total_bytes)) {
  // sealed first: no reader sees a file that can still shrink
  HAPTIC_ASSERT(spec.total_bytes >= sizeof(SegmentHeader));
  add_seals(fd_.get(), F_SEAL_SHRINK | F_SEAL_GROW);
  region_ = map_all(fd_.get(), bip::read_write, spec.total_bytes);

  auto* h = new (memory()) SegmentHeader{};
  h->abi_major = kAbiMajor;
  h->abi_minor = kAbiMinor;
  h->layout_hash = spec.layout_hash;
  h->total_bytes = spec.total_bytes;
  h->segment_id = static_cast<uint32_t>(spec.id);
  h->generation = generation;
  h->pid = static_cast<uint64_t>(getpid());
  h->process_start = start_time_of(getpid());
  h->clock_id = CLOCK_MONOTONIC;
}

void WritableSegment::publish() {
  HAPTIC_ASSERT(header().magic.load() == 0);
  header().magic.store(kSegmentMagic, std::memory_order_release);
  add_seals(fd_.get(), F_SEAL_FUTURE_WRITE | F_SEAL_SEAL);
}

SegmentMapping::SegmentMapping(FileDescriptor fd, const SegmentSpec& spec,
                               const ViewOptions& options) {
  const Validation check(spec);
  check.check_file(fd.get());
  region_ = map_all(fd.get(), bip::read_only, spec.total_bytes);
  check.check_magic(header(), options.ready_timeout_ns);
  check.check_header(header());
  generation_ = header().generation.load(std::memory_order_relaxed);
  // only now: what is refused costs no memory. A page that memory has no room for would end the
  // reader later; kernels before 5.14 cannot say
  if (options.populate &&
      madvise(region_.get_address(), region_.get_size(), MADV_POPULATE_READ) != 0) {
    check.require(errno == EINVAL, SegmentFault::kSystem,
                  std::string("cannot have its pages: ") + std::strerror(errno));
  }
  if (options.lock_memory) mlock(memory(), spec.total_bytes);
}

}  // namespace haptic
