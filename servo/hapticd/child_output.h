// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// What a child writes to its stderr, line by line, so that it comes out in hapticd's own form.
class ChildOutput {
 public:
  using UseLine = std::function<void(const std::string&)>;

  /// Makes the pipe. Throws std::system_error.
  explicit ChildOutput(std::string_view program);

  /// The child's end: becomes its stderr. Close it in hapticd once the child runs.
  FileDescriptor& child_end() noexcept { return write_; }
  /// To be polled; −1 once the child has closed its end.
  int poll_fd() const noexcept { return read_.get(); }

  /// Hands over every whole line that has come, without the child's own "program: " in front. An
  /// unfinished line waits for its end, or for `flush()`.
  void read(const UseLine& use);
  /// The same, and what is left when the child has ended.
  void flush(const UseLine& use);

 private:
  void use_line(const UseLine& use, std::string_view line) const;

  std::string prefix_;
  std::string partial_;
  FileDescriptor read_, write_;
};

}  // namespace haptic
