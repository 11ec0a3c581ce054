// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "proto/os/file_descriptor.h"

/// Files that are read to their end. Not so pipes, devices, sockets and folders: opening a pipe
/// waits for its writer, and /dev/zero has no end.
namespace haptic {

/// A file open for reading, or the reason why it is not.
struct RegularFile {
  FileDescriptor descriptor;
  uint64_t size = 0;    // when it was opened [bytes]
  std::string problem;  // empty: open; else the message after "PATH: ", without how to mend it
};

/// Opens a regular file; never waits.
RegularFile open_regular_file(const std::string& path);

/// The kind of what is at a path, if it is no regular file: "is a pipe".
std::string kind_problem(mode_t mode);

/// Why a path cannot be read as a file, as RegularFile::problem; empty: `in` reads it.
std::string open_stream(const std::string& path, std::ifstream& in);

/// Reads a whole file of at most `most` bytes into `text`. Returns the problem; empty: none.
std::string read_regular_file(const std::string& path, size_t most, std::string& text);

/// Writes all bytes to a regular file, from `offset` on; false, with errno, if it could not.
bool write_all(int file, std::span<const std::byte> bytes, uint64_t offset = 0);

}  // namespace haptic
