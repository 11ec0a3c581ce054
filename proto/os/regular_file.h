// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>

#include "proto/os/file_descriptor.h"

/// Files that are read to their end. A pipe, a device, a socket or a folder is none: opening a pipe
/// waits for whoever writes to it, and /dev/zero has no end.
namespace haptic {

/// A file open for reading, or why it is not.
struct RegularFile {
  FileDescriptor descriptor;
  uint64_t size = 0;    // when it was opened [bytes]
  std::string problem;  // empty: it is open. Else what follows "PATH: ", without how to mend it
};

/// Opens a regular file; never waits.
RegularFile open_regular_file(const std::string& path);

/// What an entry of a folder is when it is no regular file: "is a pipe".
std::string kind_problem(mode_t mode);

/// Why a path cannot be read as a file, as RegularFile::problem; empty: it can, and `in` reads it.
std::string open_stream(const std::string& path, std::ifstream& in);

/// Reads a whole file of at most `most` bytes. Returns the problem; empty: it is in `text`.
std::string read_regular_file(const std::string& path, size_t most, std::string& text);

}  // namespace haptic
