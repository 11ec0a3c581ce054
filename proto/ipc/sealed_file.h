// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "proto/ipc/segment.h"

namespace haptic {

/// Maps all of a sealed file (make_sealed_file) read-only; what it returns keeps the mapping.
/// Nobody can change or shorten such a file, so what has been checked stays true. Throws
/// SegmentError if a seal is missing, if the file is empty or has more than `most` bytes.
struct SealedMapping {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};
SealedMapping map_sealed_file(FileDescriptor fd, size_t most);

}  // namespace haptic
