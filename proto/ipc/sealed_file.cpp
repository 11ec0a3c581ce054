// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/sealed_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace haptic {

SealedMapping map_sealed_file(FileDescriptor fd, size_t most) {
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
  const auto fail = [](SegmentFault fault, const std::string& what) {
    throw SegmentError(fault, "a file handed out by the session: " + what);
  };
  const int seals = fcntl(fd.get(), F_GET_SEALS);
  if (seals < 0 || (seals & kSeals) != kSeals) {
    fail(SegmentFault::kNotSealed,
         "it is not sealed against every change; only files made by hapticd's processes are read");
  }
  struct stat status {};
  if (fstat(fd.get(), &status) != 0) fail(SegmentFault::kSystem, std::strerror(errno));
  if (status.st_size == 0) fail(SegmentFault::kTooShort, "it is empty");
  if (std::cmp_greater(status.st_size, most)) {
    fail(SegmentFault::kTooLong, std::to_string(status.st_size) + " bytes, more than is read (" +
                                     std::to_string(most) + ")");
  }
  const auto size = static_cast<size_t>(status.st_size);
  void* memory = mmap(nullptr, size, PROT_READ, MAP_SHARED, fd.get(), 0);
  if (memory == MAP_FAILED) fail(SegmentFault::kSystem, std::strerror(errno));
  std::shared_ptr<const void> storage(memory, [size](void* start) { munmap(start, size); });
  return {{static_cast<const std::byte*>(memory), size}, std::move(storage)};
}

}  // namespace haptic
