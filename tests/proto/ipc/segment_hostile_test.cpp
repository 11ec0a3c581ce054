// SPDX-License-Identifier: GPL-3.0-or-later
// Attempts of a reader to change a published segment: each is refused and nothing changes.
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstring>

#include "clients/lab/support/forked_process.h"
#include "tests/proto/ipc/segment_image.h"

namespace haptic {
namespace {

using test::Bytes;
constexpr size_t kControlBytes = kSegmentSpec<ControlChannels>.total_bytes;

/// A published segment with one frame, and a copy of its bytes.
class Target {
 public:
  Target() {
    frame_.revision = 9;
    writer_.channels().frames.publish(frame_);
    before_ = bytes();
  }
  int fd() const { return writer_.fd(); }
  FileDescriptor reader() const { return reopen_read_only(fd()); }
  /// Opening for writing succeeds, but must be useless.
  FileDescriptor reopened_for_writing() const {
    const std::string path = "/proc/self/fd/" + std::to_string(fd());
    FileDescriptor hostile(open(path.c_str(), O_RDWR | O_CLOEXEC));
    REQUIRE(hostile.is_open());
    return hostile;
  }
  bool is_unchanged() const {
    struct stat status {};
    return fstat(fd(), &status) == 0 && status.st_size == off_t(kControlBytes) &&
           bytes() == before_;
  }
  /// The writer continues, and a reader sees it.
  bool is_alive() {
    const SegmentView<ControlChannels> view(reader());
    ++frame_.revision;
    writer_.channels().frames.publish(frame_);
    ControlFrame out;
    return view.channels().frames.latest(out) && out.revision == frame_.revision;
  }

 private:
  Bytes bytes() const {
    Bytes all(kControlBytes);
    REQUIRE(pread(fd(), all.data(), all.size(), 0) == ssize_t(kControlBytes));
    return all;
  }
  SegmentWriter<ControlChannels> writer_{1};
  ControlFrame frame_{};
  Bytes before_;
};

/// A mapping that is removed with its owner.
class Mapping {
 public:
  Mapping(int fd, int protection, int flags)
      : memory_(mmap(nullptr, kControlBytes, protection, flags, fd, 0)), error_(errno) {}
  ~Mapping() {
    if (is_mapped()) munmap(memory_, kControlBytes);
  }
  Mapping(const Mapping&) = delete;
  bool is_mapped() const { return memory_ != MAP_FAILED; }
  bool is_refused(int error) const { return !is_mapped() && error_ == error; }
  char* memory() const { return static_cast<char*>(memory_); }

 private:
  void* memory_;
  int error_;
};

constexpr char kJunk[64] = {1, 2, 3};

bool refused(ssize_t result, int error) {
  return result == -1 && errno == error;
}

}  // namespace

TEST_CASE("hostile reader: writing through its mapping kills it and nobody else") {
  Target target;
  const SegmentView<ControlChannels> view(target.reader());
  const size_t at = GENERATE(size_t{0}, offsetof(SegmentHeader, heartbeat), sizeof(SegmentHeader),
                             kControlBytes / 2, kControlBytes - 1);
  ForkedProcess writing([&] {
    signal(SIGSEGV, SIG_DFL);  // a sanitizer would turn it into an exit code
    *const_cast<volatile char*>(static_cast<const char*>(view.memory()) + at) = 1;
  });
  const int status = writing.wait();
  CHECK(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == SIGSEGV);
  CHECK(target.is_unchanged());
  CHECK(target.is_alive());
}

TEST_CASE("hostile reader: the descriptor it was given cannot be used for writing") {
  Target target;
  const FileDescriptor reader = target.reader();
  const int fd = reader.get();
  CHECK(refused(write(fd, kJunk, sizeof kJunk), EBADF));
  CHECK(refused(pwrite(fd, kJunk, sizeof kJunk, 0), EBADF));
  CHECK(refused(ftruncate(fd, 0), EINVAL));
  CHECK(refused(fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), EBADF));
  CHECK(refused(fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE), EPERM));
  CHECK(Mapping(fd, PROT_READ | PROT_WRITE, MAP_SHARED).is_refused(EACCES));
  CHECK(Mapping(fd, PROT_WRITE, MAP_SHARED).is_refused(EACCES));
  CHECK(target.is_unchanged());
  CHECK(target.is_alive());
}

TEST_CASE("hostile reader: a descriptor reopened for writing cannot be used for writing") {
  Target target;
  const FileDescriptor hostile = target.reopened_for_writing();
  const int fd = hostile.get();
  iovec part{const_cast<char*>(kJunk), sizeof kJunk};
  CHECK(refused(write(fd, kJunk, sizeof kJunk), EPERM));
  CHECK(refused(pwrite(fd, kJunk, sizeof kJunk, 0), EPERM));
  CHECK(refused(pwritev(fd, &part, 1, 4096), EPERM));
  const FileDescriptor source(open("/dev/zero", O_RDONLY | O_CLOEXEC));
  CHECK(sendfile(fd, source.get(), nullptr, 64) == -1);
  const FileDescriptor image = test::file_with(Bytes(4096, std::byte{7}));
  loff_t from = 0, to = 0;
  CHECK(copy_file_range(image.get(), &from, fd, &to, 4096, 0) == -1);
  for (const off_t size :
       {off_t{0}, off_t{4096}, off_t(kControlBytes - 1), off_t(2 * kControlBytes)}) {
    CAPTURE(size);
    CHECK(refused(ftruncate(fd, size), EPERM));
  }
  CHECK(refused(fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), EPERM));
  CHECK(refused(fallocate(fd, 0, 0, off_t(2 * kControlBytes)), EPERM));
  CHECK(fallocate(fd, FALLOC_FL_ZERO_RANGE, 0, 4096) == -1);
  CHECK(fallocate(fd, FALLOC_FL_COLLAPSE_RANGE, 0, 4096) == -1);
  for (const int seal : {F_SEAL_WRITE, F_SEAL_SHRINK, F_SEAL_SEAL}) {
    CHECK(refused(fcntl(fd, F_ADD_SEALS, seal), EPERM));
  }
  CHECK(Mapping(fd, PROT_READ | PROT_WRITE, MAP_SHARED).is_refused(EPERM));
  CHECK(target.is_unchanged());
  CHECK(target.is_alive());
}

TEST_CASE(
    "hostile reader: a read-only mapping cannot be made writable, emptied or written around") {
  Target target;
  const FileDescriptor hostile = target.reopened_for_writing(), reader = target.reader();
  const int fd = GENERATE_REF(hostile.get(), reader.get());
  const Mapping mapping(fd, PROT_READ, MAP_SHARED);
  REQUIRE(mapping.is_mapped());
  CHECK(refused(mprotect(mapping.memory(), kControlBytes, PROT_READ | PROT_WRITE), EACCES));
  CHECK(madvise(mapping.memory(), kControlBytes, MADV_REMOVE) == -1);
  // harmless: the pages are restored as they were
  madvise(mapping.memory(), kControlBytes, MADV_DONTNEED);
  iovec local{const_cast<char*>(kJunk), sizeof kJunk}, remote{mapping.memory(), sizeof kJunk};
  CHECK(process_vm_writev(getpid(), &local, 1, &remote, 1, 0) == -1);
  const FileDescriptor memory(open("/proc/self/mem", O_RDWR | O_CLOEXEC));
  CHECK(pwrite(memory.get(), kJunk, sizeof kJunk, reinterpret_cast<off_t>(mapping.memory())) == -1);
  CHECK(target.is_unchanged());
  CHECK(target.is_alive());
}

TEST_CASE("hostile reader: what it writes into a private copy stays with it") {
  Target target;
  const FileDescriptor reader = target.reader();
  const Mapping copy(reader.get(), PROT_READ | PROT_WRITE, MAP_PRIVATE);
  REQUIRE(copy.is_mapped());
  std::memset(copy.memory(), 0xff, kControlBytes);
  CHECK(target.is_unchanged());
  CHECK(target.is_alive());
}

}  // namespace haptic
