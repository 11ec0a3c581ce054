// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/child_output.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace haptic {
namespace {

constexpr size_t kLongestLine = 16 << 10;  // [bytes]; longer lines are passed on in pieces

}  // namespace

ChildOutput::ChildOutput(std::string_view program) : prefix_(std::string(program) + ": ") {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot make a pipe");
  }
  read_ = FileDescriptor(ends[0]);
  write_ = FileDescriptor(ends[1]);
  fcntl(read_.get(), F_SETFL, O_NONBLOCK);
}

void ChildOutput::read(const UseLine& use) {
  std::array<char, 4096> bytes;
  while (read_.is_open()) {
    const ssize_t n = ::read(read_.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) read_.reset();
    if (n <= 0) break;
    partial_.append(bytes.data(), static_cast<size_t>(n));
    for (size_t end = 0; (end = partial_.find('\n')) != std::string::npos;) {
      use_line(use, std::string_view(partial_).substr(0, end));
      partial_.erase(0, end + 1);
    }
    if (partial_.size() > kLongestLine) {
      use_line(use, partial_);
      partial_.clear();
    }
  }
}

void ChildOutput::flush(const UseLine& use) {
  read(use);
  use_line(use, partial_);
  partial_.clear();
}

void ChildOutput::use_line(const UseLine& use, std::string_view line) const {
  if (line.starts_with(prefix_)) line.remove_prefix(prefix_.size());
  if (!line.empty()) use(std::string(line));
}

}  // namespace haptic
