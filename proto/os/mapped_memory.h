// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <memory>

namespace haptic {

struct Unmap {
  size_t bytes = 0;
  void operator()(void* memory) const noexcept { munmap(memory, bytes); }
};

/// The bytes of a file in memory, shared with whoever maps it too.
using MappedMemory = std::unique_ptr<void, Unmap>;

/// Maps the beginning of an open file; null, with errno set, if the kernel refuses.
inline MappedMemory map_shared(int fd, size_t bytes, int protection, int flags = 0) {
  void* memory = mmap(nullptr, bytes, protection, MAP_SHARED | flags, fd, 0);
  return {memory == MAP_FAILED ? nullptr : memory, Unmap{bytes}};
}

}  // namespace haptic
