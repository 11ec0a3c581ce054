// SPDX-License-Identifier: Apache-2.0
#include "proto/os/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace haptic {

std::string kind_problem(mode_t mode) {
  if (S_ISREG(mode)) return "";
  if (S_ISDIR(mode)) return "is a folder";
  if (S_ISFIFO(mode)) return "is a pipe";
  if (S_ISSOCK(mode)) return "is a socket";
  return "is a device";
}

RegularFile open_regular_file(const std::string& path) {
  RegularFile out;
  // non-blocking: does not wait for the writer of a pipe; a terminal does not become the
  // controlling one
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status {};
  // a socket cannot be opened, but its kind can be named
  const bool known =
      file.is_open() ? ::fstat(file.get(), &status) == 0 : ::stat(path.c_str(), &status) == 0;
  if (known) out.problem = kind_problem(status.st_mode);
  if (!out.problem.empty()) return out;
  if (!known || !file.is_open()) {
    out.problem = std::string("cannot be read (") + std::strerror(errno) + ")";
    return out;
  }
  out.size = static_cast<uint64_t>(status.st_size);
  out.descriptor = std::move(file);
  return out;
}

std::string open_stream(const std::string& path, std::ifstream& in) {
  const RegularFile file = open_regular_file(path);
  if (!file.problem.empty()) return file.problem;
  // the checked file, even if its name was reused meanwhile
  in.open("/proc/self/fd/" + std::to_string(file.descriptor.get()), std::ios::binary);
  return in ? "" : std::string("cannot be read (") + std::strerror(errno) + ")";
}

std::string read_regular_file(const std::string& path, size_t most, std::string& text) {
  const RegularFile file = open_regular_file(path);
  if (!file.problem.empty()) return file.problem;
  text.clear();
  std::array<char, 1 << 16> bytes;
  for (;;) {
    const ssize_t n = ::read(file.descriptor.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return std::string("cannot be read (") + std::strerror(errno) + ")";
    if (n == 0) return "";
    text.append(bytes.data(), static_cast<size_t>(n));
    if (text.size() > most) return "has more than " + std::to_string(most >> 10) + " KiB";
  }
}

bool write_all(int file, std::span<const std::byte> bytes, uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = ENOSPC;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(n));
    offset += static_cast<uint64_t>(n);
  }
  return true;
}

}  // namespace haptic
