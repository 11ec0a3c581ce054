// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// A file mapped read-only, or bytes in memory; they live as long as `storage`.
struct MappedFile {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};

/// Maps a file; an empty file has no bytes and no storage. Throws std::runtime_error with the
/// system's reason.
MappedFile map_file(const std::string& path);

/// Maps the open file itself, even if its name now refers to another one; it must not be empty.
/// Throws std::runtime_error with the system's reason.
MappedFile map_descriptor(const FileDescriptor& descriptor);

/// A function that returns the bytes of a file; it may need far more memory than it returns.
using ByteMaker = std::function<std::vector<std::byte>()>;

/// The bytes of `make`, which runs here.
MappedFile make_here(const ByteMaker& make);

/// The bytes of `make`, which runs in a forked child: whatever else it allocates ends with the
/// child, which dies with this thread. Where the child fails, `make` runs here, so that its
/// exception or its death is this process's. Call it while the process has one thread.
MappedFile make_apart(const ByteMaker& make);

}  // namespace haptic
